//! Names that say more than the quantity, such as whose it is or that it was measured: `current_iq_A`, `Motor current(A)`, `Velocity actual value [rpm]`.

use super::known::Slot;
use super::words::{self, parts, split};

/// Words that leave a quantity what it is: an axis has one motor, and what is recorded was measured.
#[rustfmt::skip]
const QUALIFIERS: [&str; 21] = [
    "motor", "mot", "moteur", "motore", "drive", "servo", "actuator", "axis", "actual", "act", "measured", "meas", "mesure", "feedback", "fbk", "fb",
    "value", "val", "ist", "istwert", "wert",
];

/// Words that are of a quantity where no other column is; elsewhere too little.
#[rustfmt::skip]
const PHRASES: [(&str, Slot); 37] = [
    ("current_iq", Slot::Effort), ("iq_current", Slot::Effort), ("current_q", Slot::Effort), ("q_current", Slot::Effort), ("i_q", Slot::Effort),
    ("active_current", Slot::Effort), ("quadrature_current", Slot::Effort), ("torque_current", Slot::Effort),
    ("torque_generating_current", Slot::Effort), ("torque_producing_current", Slot::Effort), ("current_torque_generating", Slot::Effort),
    ("curr", Slot::Effort), ("cur", Slot::Effort), ("trq", Slot::Effort), ("torq", Slot::Effort),
    ("motorstrom", Slot::Effort), ("stromistwert", Slot::Effort), ("motormoment", Slot::Effort), ("momentenistwert", Slot::Effort),
    ("drehmomentistwert", Slot::Effort), ("kraftistwert", Slot::Effort), ("courant", Slot::Effort), ("couple", Slot::Effort),
    ("corrente", Slot::Effort), ("coppia", Slot::Effort), ("corriente", Slot::Effort),
    ("encoder_position", Slot::Position), ("position_encoder", Slot::Position), ("encoder_angle", Slot::Position), ("motorposition", Slot::Position),
    ("lageistwert", Slot::Position), ("positionsistwert", Slot::Position),
    ("velo", Slot::Velocity), ("vitesse", Slot::Velocity), ("motordrehzahl", Slot::Velocity), ("drehzahlistwert", Slot::Velocity),
    ("geschwindigkeitsistwert", Slot::Velocity),
];

/// The quantity of a name whose other words change nothing.
pub(super) fn slot(name: &str) -> Option<Slot> {
    let said = parts(split(name).0);
    let (qualifiers, rest): (Vec<&str>, Vec<&str>) = said
        .iter()
        .map(String::as_str)
        .partition(|part| QUALIFIERS.contains(part));
    let rest = rest.join("_");
    // A drive's voltage is as often that of its supply.
    if rest == "voltage" && !qualifiers.contains(&"motor") {
        return None;
    }
    let phrase = PHRASES.iter().find(|p| p.0 == rest).map(|p| p.1);
    phrase.or_else(|| words::word(&rest))
}
