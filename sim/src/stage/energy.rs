//! Where the energy went: the check that the simulation creates none.

/// Energies since the start \[J\]. Positive `supplied_j` and `external_j` went in, the others came out or are stored.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Energy {
    /// From the bridge: ∫V·i dt.
    pub supplied_j: f64,
    /// From the external force and the disturbances.
    pub external_j: f64,
    /// Heat of the winding.
    pub winding_j: f64,
    /// Work done against the friction truth, of which its elements give back a little at each reversal.
    pub friction_j: f64,
    /// Heat of the viscous friction, of the rotor's damping and of the coupling.
    pub viscous_j: f64,
    /// Held by the inductance, the moving parts and the coupling.
    pub stored_j: f64,
}

impl Energy {
    /// What does not add up \[J\]: the error of the integration and of this account.
    pub fn residual_j(&self) -> f64 {
        self.supplied_j + self.external_j
            - self.winding_j
            - self.friction_j
            - self.viscous_j
            - self.stored_j
    }
}
