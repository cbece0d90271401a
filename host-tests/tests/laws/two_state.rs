//! The two-state elasto-plastic model from absolute positions, its level integrated in time.

use preslide_host_tests::reference::Stribeck;
use preslide_host_tests::reference::ode::integrate;

/// The model and its memory.
pub struct TwoState {
    /// `s` (m).
    distance: f64,
    stribeck: Stribeck,
    /// `C` (N/s).
    attraction: f64,
    /// `T_s` (s).
    sample_time: f64,
    /// Length of a count (m).
    count: f64,
    /// Position and position of the last reversal (counts, exact).
    position: i64,
    reversal: i64,
    start: f64,
    force: f64,
    level: f64,
    rising: bool,
}

impl TwoState {
    /// At rest; see the fields for units.
    pub fn new(
        distance: f64,
        stribeck: Stribeck,
        attraction: f64,
        sample_time: f64,
        count: f64,
    ) -> Self {
        Self {
            distance,
            attraction,
            sample_time,
            count,
            position: 0,
            reversal: 0,
            start: 0.0,
            force: 0.0,
            level: stribeck.breakaway,
            stribeck,
            rising: true,
        }
    }

    /// Moves by whole counts in one sample time at the velocity `velocity` (m/s); the force (N) at its end.
    pub fn advance(&mut self, counts: i32, velocity: f64) -> f64 {
        if counts == 0 && velocity == 0.0 {
            return self.force;
        }
        let strength = self.stribeck.force(velocity);
        self.level = integrate(
            |level| self.attraction * (1.0 - level / strength),
            self.level,
            self.sample_time,
            1e-15,
        );
        if counts != 0 && (counts > 0) != self.rising {
            self.rising = counts > 0;
            self.reversal = self.position;
            self.start = self.force;
        }
        self.position += i64::from(counts);
        let way = (self.position - self.reversal).abs() as f64 * self.count / self.distance;
        if way > 0.0 {
            let curve = if way < 1.0 { way - way * way.ln() } else { 1.0 };
            let end = if self.rising { self.level } else { -self.level };
            self.force = (1.0 - curve) * self.start + curve * end;
        }
        self.force
    }
}
