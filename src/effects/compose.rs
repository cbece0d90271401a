//! Tuples of effects are effects: the sum of their terms, known at compile time.

use super::{Bounds, Effect, Situation};
use crate::Scalar;

/// No effect: no state, no code.
impl<S: Scalar> Effect<S> for () {
    type State = ();

    fn at_rest(&self) {}

    fn bounds(&self) -> Bounds<S> {
        Bounds::NONE
    }
}

macro_rules! tuple {
    ($($name:ident $at:tt)+) => {
        impl<S: Scalar, $($name: Effect<S>),+> Effect<S> for ($($name,)+) {
            type State = ($($name::State,)+);

            const LEVEL: bool = $($name::LEVEL)||+;
            const FORCE: bool = $($name::FORCE)||+;
            const SHIFT: bool = $($name::SHIFT)||+;

            fn at_rest(&self) -> Self::State {
                ($(self.$at.at_rest(),)+)
            }

            #[inline]
            fn level(&self, state: &mut Self::State, at: &Situation<S>) -> S {
                let mut sum = S::ZERO;
                $(if $name::LEVEL && (at.located || !$name::PLACED) {
                    sum = sum.add_input(self.$at.level(&mut state.$at, at));
                })+
                sum
            }

            #[inline]
            fn force(&self, state: &mut Self::State, at: &Situation<S>) -> S {
                let mut sum = S::ZERO;
                $(if $name::FORCE && (at.located || !$name::PLACED) {
                    sum = sum.add_input(self.$at.force(&mut state.$at, at));
                })+
                sum
            }

            #[inline]
            fn shift(&self, position: S) -> S {
                let mut sum = S::ZERO;
                $(if $name::SHIFT {
                    sum = sum.add_input(self.$at.shift(position));
                })+
                sum
            }

            fn bounds(&self) -> Bounds<S> {
                let mut sum = Bounds::<S>::NONE;
                $({
                    let own = self.$at.bounds();
                    sum.level = sum.level.add_input(own.level);
                    sum.force = sum.force.add_input(own.force);
                    sum.shift = sum.shift.add_input(own.shift);
                })+
                sum
            }
        }
    };
}

tuple!(A 0);
tuple!(A 0 B 1);
tuple!(A 0 B 1 C 2);
tuple!(A 0 B 1 C 2 D 3);
tuple!(A 0 B 1 C 2 D 3 E 4);
tuple!(A 0 B 1 C 2 D 3 E 4 G 5);
tuple!(A 0 B 1 C 2 D 3 E 4 G 5 H 6);
tuple!(A 0 B 1 C 2 D 3 E 4 G 5 H 6 I 7);
