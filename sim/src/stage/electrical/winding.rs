//! The winding between the bridge's edges, solved exactly.

use std::ops::AddAssign;

/// The bridge during one PWM period; see [`super`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridge {
    /// −1…1; its sign says which half bridge switches.
    pub duty: f64,
    /// Supply \[V\].
    pub supply_v: f64,
    /// A PWM period \[s\].
    pub period_s: f64,
    /// Dead time \[s\].
    pub dead_time_s: f64,
    /// Forward voltage of a diode \[V\].
    pub diode_v: f64,
}

/// The half bridge that switches.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Leg {
    Low,
    High,
    /// Both gates are off.
    Floating,
}

impl Bridge {
    /// The parts of a period: until when \[s\], and what the switching half does. The pulse is in the middle; a half bridge whose
    /// duty is 0 or 1 does not switch.
    fn parts(&self) -> [(f64, Leg); 5] {
        let on = 0.5 * self.period_s * (1.0 - self.duty.abs());
        let off = self.period_s - on;
        let end = self.period_s;
        if self.duty == 0.0 || on <= 0.0 {
            let leg = if self.duty == 0.0 {
                Leg::Low
            } else {
                Leg::High
            };
            return [(end, leg); 5];
        }
        [
            (on, Leg::Low),
            // A pulse shorter than the dead time never reaches the high side.
            ((on + self.dead_time_s).min(off), Leg::Floating),
            (off, Leg::High),
            // What would reach into the next period is cut off.
            ((off + self.dead_time_s).min(end), Leg::Floating),
            (f64::INFINITY, Leg::Low),
        ]
    }
}

/// What passed through the winding in some time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Passed {
    /// ∫i dt [A·s].
    pub charge: f64,
    /// ∫i² dt [A²·s].
    pub square: f64,
    /// ∫v·i dt, v across the winding's ends \[J\].
    pub work_j: f64,
}

impl AddAssign for Passed {
    fn add_assign(&mut self, other: Self) {
        self.charge += other.charge;
        self.square += other.square;
        self.work_j += other.work_j;
    }
}

/// Inductance and resistance, and the current in them.
#[derive(Debug, Clone)]
pub struct Winding {
    inductance_h: f64,
    resistance_ohm: f64,
    /// Current \[A\], positive for a positive duty.
    pub current_a: f64,
}

impl Winding {
    /// Without current.
    pub fn new(inductance_h: f64, resistance_ohm: f64) -> Self {
        Self {
            inductance_h,
            resistance_ohm,
            current_a: 0.0,
        }
    }

    /// Resistance \[Ω\].
    pub fn resistance_ohm(&self) -> f64 {
        self.resistance_ohm
    }

    /// Another resistance \[Ω\] from now on.
    pub fn set_resistance(&mut self, resistance_ohm: f64) {
        self.resistance_ohm = resistance_ohm;
    }

    /// What passes between two times of the period \[s\] with the back-EMF held \[V\].
    pub fn pass(&mut self, bridge: &Bridge, from_s: f64, to_s: f64, back_emf_v: f64) -> Passed {
        // The other half bridge is the mirror image.
        let sign = if bridge.duty < 0.0 { -1.0 } else { 1.0 };
        let back_emf_v = sign * back_emf_v;
        self.current_a *= sign;
        let mut passed = Passed::default();
        let mut at = from_s;
        for (end, leg) in bridge.parts() {
            let end = end.min(to_s);
            if end <= at {
                continue;
            }
            passed += match leg {
                Leg::Low => self.conduct(0.0, back_emf_v, end - at),
                Leg::High => self.conduct(bridge.supply_v, back_emf_v, end - at),
                Leg::Floating => self.float(bridge, back_emf_v, end - at),
            };
            at = end;
        }
        self.current_a *= sign;
        passed.charge *= sign;
        passed
    }

    /// With `voltage_v` at the switching end: `i = i_∞ + (i − i_∞)·e^{−t/τ}`.
    fn conduct(&mut self, voltage_v: f64, back_emf_v: f64, time_s: f64) -> Passed {
        let tau = self.inductance_h / self.resistance_ohm;
        let settled = (voltage_v - back_emf_v) / self.resistance_ohm;
        let excess = self.current_a - settled;
        let gone = -(-time_s / tau).exp_m1();
        self.current_a = settled + excess * (1.0 - gone);
        let charge = settled * time_s + excess * tau * gone;
        Passed {
            charge,
            square: settled * (settled * time_s + 2.0 * excess * tau * gone)
                + 0.5 * excess * excess * tau * gone * (2.0 - gone),
            work_j: voltage_v * charge,
        }
    }

    /// Through a diode, until no current is left that it would carry.
    fn float(&mut self, bridge: &Bridge, back_emf_v: f64, time_s: f64) -> Passed {
        let (low, high) = (-bridge.diode_v, bridge.supply_v + bridge.diode_v);
        let voltage = if self.current_a > 0.0 || (self.current_a == 0.0 && back_emf_v < low) {
            low
        } else if self.current_a < 0.0 || back_emf_v > high {
            high
        } else {
            return Passed::default();
        };
        let settled = (voltage - back_emf_v) / self.resistance_ohm;
        // Where the current heads beyond zero, the time at which it is there: e^{t/τ} = 1 − i/i_∞.
        let ends = self.current_a * settled < 0.0;
        let tau = self.inductance_h / self.resistance_ohm;
        let end = tau * (-self.current_a / settled).ln_1p();
        if !ends || end >= time_s {
            return self.conduct(voltage, back_emf_v, time_s);
        }
        let passed = self.conduct(voltage, back_emf_v, end);
        // No diode takes it further, unless the back-EMF is larger than the supply.
        self.current_a = 0.0;
        passed
    }
}
