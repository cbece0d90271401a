"""Numbers of the effects inside the integrator, and the names outside."""

KNOWN = [
    "viscous",
    "quadratic_drag",
    "stribeck",
    "coulomb_asymmetry",
    "constant_force",
    "position_spring",
    "position_force",
    "position_friction",
    "local_friction_spot",
    "periodic_force",
    "periodic_friction",
    "encoder_error",
    "channel_delay",
    "drive_compliance",
    "backlash",
    "thermal_drift",
    "run_in",
    "dwell_aging",
    "external_vibration",
    "load_dependent_friction",
    "frictional_lag",
    "gravity",
    "actuator_dead_zone",
    "actuator_saturation",
    "axis_coupling",
]
STRANGE = [
    "rattling_mass",
    "supply_sag",
    "film_memory",
    "wiper_relaxation",
    "sticky_brake",
    "gain_fading",
    "eddy_drag_peak",
    "sloshing_tank",
    "chip_heap",
    "leaking_air_spring",
    "magnetic_hysteresis",
    "amplifier_dropout",
    "payload_change",
    "rocking_base",
    "ball_entry_noise",
    "coolant_jet",
    "seal_adhesion",
]
CODE = {name: i + 1 for i, name in enumerate(KNOWN)}
CODE.update({name: i + 101 for i, name in enumerate(STRANGE)})

# shares of the effort's deviation: drawn inside, accepted within the band
TARGET = {0.5: (0.042, 0.065), 1.0: (0.075, 0.112), 2.0: (0.145, 0.21)}
BAND = {0.5: (0.03, 0.08), 1.0: (0.06, 0.13), 2.0: (0.12, 0.25)}
