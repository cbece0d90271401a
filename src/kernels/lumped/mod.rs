//! The full law as one spring and one slider: what a tick costs does not grow with the number of blocks.

mod count;
mod float;
mod slip_reserve;

pub use count::{LumpedCountGms, LumpedCountGmsState};
pub use float::{Float, LumpedGms, LumpedGmsState};
pub use slip_reserve::{LumpedSlipReserve, LumpedSlipReserveState};

use core::ops::{Add, Neg, Sub};

/// A number of the lumped law. Displacements and forces are in units that the caller chooses; *shares* (`σ`, `λ`) are in
/// parts of [`Number::ONE`].
pub trait Number:
    Copy + PartialOrd + Add<Output = Self> + Sub<Output = Self> + Neg<Output = Self>
{
    /// 0.
    const ZERO: Self;
    /// The share 1.
    const ONE: Self;
    /// The direction forward.
    const FORWARD: Self;
    /// What a bound is lowered by, for the rounding of its products.
    const MARGIN: Self;

    /// `self` forward, `−self` backward.
    fn along(self, direction: Self) -> Self;
    /// The other direction.
    fn turned(direction: Self) -> Self;
    /// Made ready for [`Number::part`].
    fn whole(self) -> Self;
    /// What [`Number::whole`] was made of.
    fn of_whole(whole: Self) -> Self;
    /// So large a share of a whole.
    fn part(whole: Self, share: Self) -> Self;
    /// `λ·self`.
    fn lagging(self, lag: Self) -> Self;
    /// The force of a spring of this stiffness.
    fn force(stiffness: Self, deflection: Self) -> Self;
    /// `self / (1 − σ_min)`, of which `per` holds the reciprocal.
    fn per_weakening(self, per: Self) -> Self;
}

/// The parameters.
#[derive(Clone, Debug, PartialEq)]
struct Lumped<const N: usize, A> {
    springs: [Spring<A>; N],
    /// `σ_min`.
    weakest: A,
    /// For [`Number::per_weakening`]; 0 where there is no Stribeck effect to speak of.
    per_weakening: A,
    /// A travel that no spring allows.
    far: A,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Spring<A> {
    /// `D_i`, [whole](Number::whole).
    yields: A,
    stiffness: A,
}

/// What a lumped law remembers: since the last *event* (a block slipped, or the motion turned while one did) it has been a
/// spring, the blocks that stick, and a slider, those that slip. Everything is along the direction of motion.
#[derive(Clone, Debug, PartialEq)]
struct LumpedState<const N: usize, A> {
    direction: A,
    /// Since the last event.
    travel: A,
    /// Between these travels no block slips at any speed, whichever way the body moves: empty while one does.
    behind: A,
    ahead: A,
    /// The spring's force at the last event, and its stiffness.
    base: A,
    stiffness: A,
    /// No block of the spring slips before the travel `offset + slope·σ`.
    offset: A,
    slope: A,
    /// The share `m` that a slipping block carries if it carried the threshold `σ` at the last event.
    sliding: A,
    /// What is left of other blocks' distance to it.
    fading: A,
    /// `ΣW_i` of the blocks that slip, and by how much their force differed from `σ·ΣW_i` at the last event.
    weight: A,
    spread: A,
    slipping: u32,
    /// At the last event: `z_i` of a block that sticks, `z_i − σ·D_i` of one that slips.
    held: [A; N],
}

impl<const N: usize, A: Number> LumpedState<N, A> {
    #[inline(always)]
    fn force(&self) -> A {
        self.base
            + A::force(self.stiffness, self.travel)
            + A::part(self.weight, self.sliding)
            + A::part(self.spread, self.fading)
    }
}

impl<const N: usize, A: Number> Lumped<N, A> {
    fn at_rest(&self) -> LumpedState<N, A> {
        let mut state = LumpedState {
            direction: A::FORWARD,
            travel: A::ZERO,
            behind: A::ZERO,
            ahead: A::ZERO,
            base: A::ZERO,
            stiffness: A::ZERO,
            offset: A::ZERO,
            slope: A::ZERO,
            sliding: A::ZERO,
            fading: A::ZERO,
            weight: A::ZERO,
            spread: A::ZERO,
            slipping: 0,
            held: [A::ZERO; N],
        };
        self.event::<true>(&mut state, A::ZERO, [A::ONE, A::ZERO]);
        state.direction = A::FORWARD;
        state
    }

    /// A tick: `moves` says whether the velocity is not zero, `sliding` gives `σ` and `λ` at it.
    #[inline(always)]
    fn step(
        &self,
        state: &mut LumpedState<N, A>,
        displacement: A,
        moves: bool,
        sliding: impl Fn() -> [A; 2],
    ) -> A {
        let advance = displacement.along(state.direction);
        let travel = state.travel + advance;
        // Where nothing can slip the direction does not matter, and a turn is no event. `behind` may lie ahead, just after a
        // turn: there only going on is safe.
        if travel < state.ahead && (travel > state.behind || advance >= A::ZERO) {
            state.travel = travel;
            let force = state.base + A::force(state.stiffness, travel);
            return force.along(state.direction);
        }
        if !(advance > A::ZERO) {
            if advance != A::ZERO {
                return self.event::<true>(state, -advance, sliding());
            }
            if !moves {
                return state.force().along(state.direction);
            }
        }
        let [weakening, lag] = sliding();
        let bound = state.offset + A::part(state.slope, weakening);
        if !(travel < bound) {
            return self.event::<false>(state, advance, [weakening, lag]);
        }
        state.travel = travel;
        state.sliding = state.sliding + (weakening - state.sliding).lagging(lag);
        state.fading = state.fading - state.fading.lagging(lag);
        state.force().along(state.direction)
    }

    /// A tick block by block, and what spring and slider are after it.
    #[cold]
    #[inline(never)]
    fn event<const TURNS: bool>(
        &self,
        state: &mut LumpedState<N, A>,
        advance: A,
        [weakening, lag]: [A; 2],
    ) -> A {
        let (travel, sliding, fading) = (state.travel, state.sliding, state.fading);
        let mut slipping = 0;
        let [mut base, mut stiffness, mut weight, mut spread] = [A::ZERO; 4];
        let [mut ahead, mut later, mut back] = [self.far; 3];
        for (i, (held, spring)) in state.held.iter_mut().zip(&self.springs).enumerate() {
            let slipped = state.slipping >> i & 1 == 1;
            let mut z = if slipped {
                A::part(spring.yields, sliding) + A::part(held.whole(), fading)
            } else {
                *held + travel
            };
            if TURNS {
                z = -z;
            }
            let slips = slipped && !TURNS;
            let bound = A::part(spring.yields, weakening);
            let stuck = z + advance;
            if !slips && stuck < bound {
                *held = stuck;
                stiffness = stiffness + spring.stiffness;
                base = base + A::force(spring.stiffness, stuck);
                let least = A::part(spring.yields, self.weakest);
                ahead = smaller(ahead, least - stuck);
                later = smaller(later, A::of_whole(spring.yields) - stuck);
                if TURNS {
                    back = smaller(back, least + stuck);
                }
            } else {
                let beyond = z - bound;
                *held = if slips || beyond >= A::ZERO {
                    beyond - beyond.lagging(lag)
                } else {
                    A::ZERO
                };
                slipping |= 1 << i;
                weight = weight + A::force(spring.stiffness, A::of_whole(spring.yields));
                spread = spread + A::force(spring.stiffness, *held);
            }
        }
        if TURNS {
            state.direction = A::turned(state.direction);
        }
        // The least of lines that rise with `σ` lies above the line between its ends.
        let slope = (later - ahead).per_weakening(self.per_weakening).whole();
        state.slope = slope;
        state.offset = ahead - A::part(slope, self.weakest) - A::MARGIN;
        state.slipping = slipping;
        // Only a turn has looked backward.
        (state.ahead, state.behind) = match slipping {
            0 if TURNS => (ahead, -back),
            0 => (ahead, self.far),
            _ => (-self.far, self.far),
        };
        (state.base, state.stiffness) = (base, stiffness);
        (state.weight, state.spread) = (weight.whole(), spread.whole());
        (state.travel, state.sliding, state.fading) = (A::ZERO, weakening, A::ONE);
        state.force().along(state.direction)
    }
}

/// If and else: `min` on floats calls a function.
#[inline(always)]
fn smaller<A: PartialOrd>(a: A, b: A) -> A {
    if a < b { a } else { b }
}
