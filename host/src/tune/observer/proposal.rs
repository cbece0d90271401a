//! Which gains to take: as fast as the margins let the filter be.

use super::{Belief, Feedback, Gains, Machine, Margins};
use preslide::ParamError;
use preslide::control::{Axis, ObserverSettings, PidGains};
use preslide_fit::friction::FrictionModel;
use preslide_fit::model::Model;
use preslide_fit::recording::MotionKind;
use preslide_fit::report::figures::{quantity, significant};

/// What is given beside the axis (SI).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Whether it turns, by which an answer's keys have their units.
    pub motion: MotionKind,
    /// Noise of a reading beside its resolution, RMS (m).
    pub noise: f64,
    /// Breakaway force of the friction model (N).
    pub breakaway: f64,
    /// Stiffness of all its contacts (N/m).
    pub contact: f64,
    /// The drive's first mode (Hz), between rotor and load with both free.
    pub mode_hz: f64,
    /// Its damping ratio (-).
    pub mode_damping: f64,
}

/// Damping ratio of a mode that nobody measured (-): steel couplings and screws have 2…5 %.
pub const USUAL_DAMPING: f64 = 0.03;

/// By how much friction may differ from its model (-): the paper's dispersion, ±15 %.
pub const UNCERTAINTY: f64 = 0.15;

/// The time (s) in which it does so at the soonest: a reversal as quick as the position loop, of some 150 rad/s, can follow.
const CHANGES_IN: f64 = 0.007;

/// An unknown payload (kg).
pub const UNMODELLED_KG: f64 = 1.0;

/// The same of an axis that turns, in its own inertia (-): a kilogram is a quarter of the paper's mass.
const UNMODELLED_SHARE: f64 = 0.25;

/// From which difference on (-) two masses are said to differ.
const ANOTHER_MASS: f64 = 0.1;

/// From one disturbance's walk to the next that is tried (-): the gains change by a thirtieth.
const FINER: f64 = 1.25;

/// Walks that are tried at most: down to 10⁻⁶ of what friction's uncertainty says, a filter of a tenth of the speed.
const TRIES: usize = 62;

/// What every case must meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demands {
    /// Factor by which the loop's gain may grow or shrink (-).
    pub gain: f64,
    /// Phase (degrees).
    pub phase_deg: f64,
    /// Largest gain at the drive's mode (-).
    pub at_mode: f64,
}

/// 6 dB of gain; 25° of phase, five less than is usual, since contacts that stick are here a spring without the damping that their
/// hysteresis has; and half at the mode, whose damping is known to a factor of two.
pub const DEMANDS: Demands = Demands {
    gain: 2.0,
    phase_deg: 25.0,
    at_mode: 0.5,
};

impl Margins {
    /// They are at least those.
    pub fn reach(&self, demands: &Demands) -> bool {
        self.radius < 1.0
            && self.gain >= demands.gain
            && self.reduction >= demands.gain
            && self.phase_deg >= demands.phase_deg
            && self.at_mode <= demands.at_mode
    }
}

/// A machine that the loop has to bear.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// In words.
    pub name: String,
    /// In numbers.
    pub machine: Machine,
}

/// Sliding and sticking, as given and 15 % stiffer and softer; each as it is, with a kilogram or a quarter of the inertia more, and with a
/// tick of delay, and both.
pub fn cases(axis: &Axis, known: &Known) -> Vec<Case> {
    let contacts = [
        ("slides", 0.0),
        ("sticks", 1.0),
        ("sticks, +15 %", 1.0 + UNCERTAINTY),
        ("sticks, −15 %", 1.0 - UNCERTAINTY),
    ];
    let (heavier, payload) = match known.motion {
        MotionKind::Linear => (", +1 kg", UNMODELLED_KG),
        MotionKind::Rotary => (
            ", +25 % of inertia",
            UNMODELLED_SHARE * axis.feed_forward.mass,
        ),
    };
    let changes = [
        ("", "", 0.0, 0),
        (heavier, "", payload, 0),
        ("", ", a tick late", 0.0, 1),
        (heavier, ", a tick late", payload, 1),
    ];
    let case = |(contact, share): &(&str, f64),
                (loaded, late, more, delay): &(&str, &str, f64, u32)| Case {
        name: format!("{contact}{loaded}{late}"),
        machine: Machine {
            mass: axis.feed_forward.mass + more,
            braking: axis.motor.braking(),
            contact: share * known.contact,
            mode_hz: known.mode_hz,
            mode_damping: known.mode_damping,
            delay: *delay,
        },
    };
    (contacts.iter())
        .flat_map(|contact| changes.iter().map(move |change| case(contact, change)))
        .collect()
}

/// Gains, and what they leave.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// Of the axis.
    pub motion: MotionKind,
    /// For the controller.
    pub settings: ObserverSettings,
    /// The feedback beside it: the axis's without the integral, whose place the disturbance takes.
    pub gains: PidGains,
    /// What the filter believes.
    pub belief: Belief,
    /// Every case with its margins.
    pub cases: Vec<(Case, Margins)>,
}

impl Proposal {
    /// The feedback with the observer in it.
    pub fn feedback(&self) -> Feedback {
        Feedback {
            pid: self.gains,
            belief: self.belief,
            gains: Gains {
                position: self.settings.position,
                velocity: self.settings.velocity,
                disturbance: self.settings.disturbance,
            },
        }
    }
}

impl Known {
    /// From a friction model of Maxwell-slip blocks.
    ///
    /// # Errors
    /// Why it has none.
    pub fn of_model(model: &Model, mode_hz: f64) -> Result<Self, String> {
        let FrictionModel::Gms {
            breakaway, blocks, ..
        } = &model.friction
        else {
            return Err(format!(
                "the observer's margins need the contacts' stiffness, and a {} has no blocks that have one",
                model.friction.kind()
            ));
        };
        Ok(Self {
            motion: model.motion,
            noise: 0.0,
            breakaway: *breakaway,
            contact: blocks.iter().map(|block| block.stiffness).sum(),
            mode_hz,
            mode_damping: USUAL_DAMPING,
        })
    }
}

/// Gives the axis that `file` describes the model's inertia; what is to be said of where the observer's numbers come from.
///
/// # Errors
/// A model of another kind of axis, or whose forces are none.
pub fn take_mass(axis: &mut Axis, model: &Model, file: &str) -> Result<String, String> {
    if let Some(unit) = model.effort_unit {
        return Err(format!(
            "the model's forces are in {unit} (its effort_unit), and an observer's are in N or N·m; identify it from a force, with --map force_N=K*COLUMN or torque_Nm=K*COLUMN and the drive's constant K"
        ));
    }
    // What a turn of a rotary axis is, in rad.
    let turns = (axis.motor.screw_lead / std::f64::consts::TAU - 1.0).abs() < 1e-3;
    if turns != (model.motion == MotionKind::Rotary) {
        return Err(format!(
            "the model is {}, and motor.screw_lead of {file} is {}, that of {} axis (a rotary one has 2π = 6.28319 rad); name the description of the model's axis",
            model.motion.name(),
            axis.motor.screw_lead,
            if turns { "a rotary" } else { "a linear" },
        ));
    }
    let unit = match model.motion {
        MotionKind::Linear => "kg",
        MotionKind::Rotary => "kg·m²",
    };
    let own = axis.feed_forward.mass;
    let rest = format!(
        "gains, motor, limits and the rate of {:.0} Hz are those of {file}",
        1.0 / axis.sample_time()
    );
    if model.inertia <= 0.0 {
        return Ok(format!(
            "Observer: the model has no inertia, so the moving mass is feed_forward.mass, {own} {unit}; {rest}"
        ));
    }
    axis.feed_forward.mass = model.inertia;
    let differs = (own / model.inertia - 1.0).abs() > ANOTHER_MASS;
    let differs = match differs {
        true => format!(" (feed_forward.mass of {file} is {own} {unit}: correct it)"),
        false => String::new(),
    };
    Ok(format!(
        "Observer: the moving mass is the model's, {} {unit}{differs}; {rest}",
        significant(model.inertia)
    ))
}

/// The fastest filter that friction's uncertainty asks for and every case bears.
///
/// # Errors
/// What is not usable in the axis, or why no filter will do.
pub fn propose(axis: &Axis, known: &Known, demands: &Demands) -> Result<Proposal, String> {
    let refused = |error: ParamError| error.to_string();
    let gains = PidGains {
        integral: 0.0,
        ..axis.gains
    };
    let uncertain = UNCERTAINTY * known.breakaway;
    let mut belief = Belief {
        sample_time: axis.sample_time(),
        mass: axis.feed_forward.mass,
        braking: axis.motor.braking(),
        // A count is as likely anywhere within ± a half.
        reading: axis.encoder.count.powi(2) / 12.0 + known.noise.powi(2),
        walk: uncertain * uncertain / CHANGES_IN,
    };
    let usable = belief.mass > 0.0 && belief.walk > 0.0 && known.mode_hz > 0.0;
    if !(usable && known.mode_damping > 0.0) {
        return Err("the observer needs a moving mass, a breakaway force, and a mode of the drive with its damping, all above zero".to_owned());
    }
    let cases = cases(axis, known);
    for _ in 0..TRIES {
        let filter = belief
            .gains()
            .ok_or("the Riccati recursion does not settle")?;
        let feedback = Feedback {
            pid: gains,
            belief,
            gains: filter,
        };
        let mut borne = Vec::new();
        for case in &cases {
            let margins = feedback.margins(&case.machine);
            if !margins.reach(demands) {
                break;
            }
            borne.push((case.clone(), margins));
        }
        if borne.len() == cases.len() {
            let settings = ObserverSettings {
                position: filter.position,
                velocity: filter.velocity,
                disturbance: filter.disturbance,
                mass: belief.mass,
                braking: belief.braking,
                limit: axis.gains.integral_limit,
                top_speed: axis.watch.top_speed,
            };
            // What it cannot be built from is no proposal.
            preslide::control::Observer::<f32>::try_new(
                &settings,
                belief.sample_time,
                preslide::Units::SI,
            )
            .map_err(refused)?;
            return Ok(Proposal {
                motion: known.motion,
                settings,
                gains,
                belief,
                cases: borne,
            });
        }
        belief.walk /= FINER;
    }
    Err(format!(
        "no observer leaves a gain margin of {}, {}° of phase and a gain of {} at the drive's mode of {:.0} Hz with the controller's gains.proportional of {}; lower that",
        demands.gain,
        demands.phase_deg,
        demands.at_mode,
        known.mode_hz,
        quantity(
            gains.proportional,
            match known.motion {
                MotionKind::Linear => "N/m",
                MotionKind::Rotary => "N·m/rad",
            }
        )
    ))
}
