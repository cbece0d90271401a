//! The force of an effect as a formula of the motion, where it has one.

use super::expr::Expr;
use super::expr::Function::{Abs, Cos, Exp, Sin, Tanh};
use super::expr::Input::{
    self, Direction, Load, Path, Position, Slipping, Temperature, Time, Velocity,
};
use crate::diagnose::effect::coulomb_asymmetry::SMALL;
use preslide_fit::statistics::Estimate;
use std::f64::consts::{PI, TAU};

/// The force (N or N·m) of the effect `id` with these parameters (in the keys of a linear axis), `level` being that of the recording's
/// friction. `None` for what is no force of the motion at one instant: the drive, the encoder, the channels, and what ages.
pub fn formula(id: &str, parameters: &[(String, Estimate)], level: f64) -> Option<Expr> {
    let find = |key: &str| {
        let own = parameters.iter().find(|(own, _)| own == key);
        own.map(|(_, estimate)| estimate.value)
    };
    let of = |input: Input| Expr::from(input);
    let past = |key: &str| Some(of(Position) + Expr::Number(-find(key)?));
    let wave = || {
        let turns = TAU / find("period_m")? * of(Position);
        Some((turns + Expr::Number(find("phase_rad")?)).of(Cos))
    };
    let cosines = |unit: &str| {
        let (from, to) = (find("from_m")?, find("to_m")?);
        let mut sum: Option<Expr> = None;
        for j in 1.. {
            let Some(size) = find(&format!("cosine{j}{unit}")) else {
                break;
            };
            let angle = f64::from(j) * PI / (to - from) * past("from_m")?;
            let part = size * angle.of(Cos);
            sum = Some(match sum {
                Some(sum) => sum + part,
                None => part,
            });
        }
        sum
    };
    let friction = |share: Expr| level * of(Direction) * share;
    Some(match id {
        "constant_force" => Expr::Number(find("force_N")?),
        "viscous" => find("viscous_N_s_per_m")? * of(Velocity),
        "viscous_asymmetry" => find("half_difference_N_s_per_m")? * of(Velocity).of(Abs),
        "quadratic_drag" => find("drag_N_s2_per_m2")? * of(Velocity) * of(Velocity).of(Abs),
        "coulomb_asymmetry" => {
            let side = (1.0 / SMALL * of(Direction)).of(Tanh);
            friction(find("asymmetry")? * side)
        }
        "stribeck" => {
            let slow =
                (1.0 / find("velocity_m_s")? * of(Velocity).of(Abs)).power(find("exponent")?);
            let fallen = find("level")? * (-1.0 * slow).of(Exp);
            match find("slipping_only") {
                Some(only) if only > 0.5 => level * of(Slipping) * fallen,
                _ => friction(fallen),
            }
        }
        "position_spring" => find("stiffness_N_per_m")? * past("centre_m")?,
        "gravity" => find("force_N")? * past("angle_rad")?.of(Sin),
        "periodic_force" => find("force_N")? * wave()?,
        "periodic_friction" => friction(find("level")? * wave()?),
        "position_force" => {
            let map = cosines("_N")?;
            match find("constant_N") {
                Some(mean) => map + Expr::Number(mean),
                None => map,
            }
        }
        "position_friction" => friction(cosines("")?),
        "local_friction_spot" => {
            let aside = 1.0 / find("width_m")? * past("position_m")?;
            friction(find("level")? * (-1.0 * aside.of(Abs).power(2.0)).of(Exp))
        }
        "external_vibration" => {
            let turns = TAU * find("frequency_Hz")? * of(Time);
            find("force_N")? * (turns + Expr::Number(find("phase_rad")?)).of(Cos)
        }
        "thermal_drift" => match find("time_constant_s") {
            Some(constant) => friction(find("level")? * (-1.0 / constant * of(Time)).of(Exp)),
            None => {
                let warmer = of(Temperature) + Expr::Number(-find("temperature_C")?);
                friction(find("level_per_K")? * warmer)
            }
        },
        "run_in" => friction(find("level")? * (-1.0 / find("path_m")? * of(Path)).of(Exp)),
        "load_dependent_friction" => {
            let more = of(Load) + Expr::Number(-find("load_N")?);
            friction(find("level_per_N")? * more)
        }
        _ => return None,
    })
}
