//! Friction laws from their papers, in units of the friction level over displacements in units of the presliding length.

/// Which law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// LuGre (Canudas de Wit et al. 1995) without a Stribeck curve: the bristle alone.
    LuGre,
    /// Elasto-plastic (Dupont et al. 2002): no drift below a share of the limit.
    ElastoPlastic,
    /// After Leuven (Swevers et al. 2000, Lampaert et al. 2002): a virgin curve doubled from each reversal, with a stack of them.
    Leuven,
    /// Bouc–Wen with an exponent of 1.5.
    BoucWen,
    /// Two bristles of unlike length in parallel.
    TwoBristles,
    /// Jenkins elements with uniform yields (Iwan 1966).
    Jenkins,
}

/// A law and what it remembers.
#[derive(Clone, Debug)]
pub enum Friction {
    /// LuGre's bristle.
    LuGre(f64),
    /// Elasto-plastic bristle.
    ElastoPlastic(f64),
    /// Reversals as (displacement, force); displacement and force now; heading.
    Leuven(Vec<[f64; 2]>, [f64; 2], f64),
    /// Bouc–Wen's variable.
    BoucWen(f64),
    /// A short and a long bristle.
    TwoBristles([f64; 2]),
    /// Displacements of the elements.
    Jenkins(Vec<f64>),
}

const ELEMENTS: usize = 30;

impl Law {
    /// At rest, unloaded.
    pub fn start(self) -> Friction {
        match self {
            Law::LuGre => Friction::LuGre(0.0),
            Law::ElastoPlastic => Friction::ElastoPlastic(0.0),
            Law::Leuven => Friction::Leuven(Vec::new(), [0.0; 2], 0.0),
            Law::BoucWen => Friction::BoucWen(0.0),
            Law::TwoBristles => Friction::TwoBristles([0.0; 2]),
            Law::Jenkins => Friction::Jenkins(vec![0.0; ELEMENTS]),
        }
    }
}

/// Exact for a bristle that is dragged at a constant rate: towards ±1 over a length of 1.
fn dragged(z: f64, ds: f64) -> f64 {
    ds.signum() + (z - ds.signum()) * (-ds.abs()).exp()
}

/// Virgin curve of [`Law::Leuven`].
fn virgin(s: f64) -> f64 {
    1.0 - 1.0 / (1.0 + s + 0.5 * s * s)
}

impl Friction {
    /// Moves by `ds` presliding lengths; `level` scales the force that is returned, in friction levels.
    pub fn step(&mut self, ds: f64, level: f64) -> f64 {
        if ds == 0.0 {
            return level * self.force();
        }
        match self {
            Friction::LuGre(z) => *z = dragged(*z, ds),
            Friction::TwoBristles([short, long]) => {
                *short = dragged(*short, 2.0 * ds);
                *long = dragged(*long, 0.25 * ds);
            }
            Friction::ElastoPlastic(z) => in_parts(ds, |ds| {
                const BREAKAWAY: f64 = 0.6;
                let share = ((z.abs() - BREAKAWAY) / (1.0 - BREAKAWAY)).clamp(0.0, 1.0);
                let alpha = if ds * *z > 0.0 {
                    0.5 - 0.5 * (std::f64::consts::PI * share).cos()
                } else {
                    0.0
                };
                *z = (*z + ds * (1.0 - alpha * z.abs())).clamp(-1.0, 1.0);
            }),
            Friction::BoucWen(z) => in_parts(ds, |ds| {
                let shape = 0.6 + 0.4 * (ds * *z).signum();
                *z = (*z + ds * (1.0 - shape * z.abs().powf(1.5))).clamp(-1.0, 1.0);
            }),
            Friction::Jenkins(elements) => {
                for (i, z) in elements.iter_mut().enumerate() {
                    let limit = 3.0 * (i as f64 + 0.5) / ELEMENTS as f64;
                    *z = (*z + ds).clamp(-limit, limit);
                }
            }
            Friction::Leuven(turns, now, heading) => leuven(turns, now, heading, ds),
        }
        level * self.force()
    }

    fn force(&self) -> f64 {
        match self {
            Friction::LuGre(z) | Friction::ElastoPlastic(z) | Friction::BoucWen(z) => *z,
            Friction::TwoBristles([short, long]) => 0.6 * short + 0.4 * long,
            Friction::Leuven(_, now, _) => now[1],
            Friction::Jenkins(elements) => {
                let share = |(i, z): (usize, &f64)| z / (3.0 * (i as f64 + 0.5) / ELEMENTS as f64);
                elements.iter().enumerate().map(share).sum::<f64>() / ELEMENTS as f64
            }
        }
    }
}

/// In steps of at most a twentieth of the presliding length; what is left of a long way changes nothing.
fn in_parts(ds: f64, mut step: impl FnMut(f64)) {
    let parts = (ds.abs() / 0.05).ceil().clamp(1.0, 400.0);
    for _ in 0..parts as usize {
        step(ds.signum() * (ds.abs() / parts).min(0.05));
    }
}

fn leuven(turns: &mut Vec<[f64; 2]>, now: &mut [f64; 2], heading: &mut f64, ds: f64) {
    if *heading != 0.0 && ds.signum() != *heading {
        turns.push(*now);
        // Far beyond what a machine resolves.
        if turns.len() > 200 {
            turns.remove(0);
        }
    }
    *heading = ds.signum();
    now[0] += ds;
    // An inner loop that has closed is forgotten with both of its reversals.
    while turns.len() >= 2 && (now[0] - turns[turns.len() - 2][0]) * *heading > 0.0 {
        turns.truncate(turns.len() - 2);
    }
    let force = match turns.last() {
        None => heading.signum() * virgin(now[0].abs()),
        Some([x, f]) => f + *heading * 2.0 * virgin(0.5 * (now[0] - x).abs()),
    };
    now[1] = force.clamp(-1.0, 1.0);
    if turns.len() == 1 && force.abs() >= 1.0 {
        turns.clear();
        now[0] = *heading * 1e3;
    }
}
