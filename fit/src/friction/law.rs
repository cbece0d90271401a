//! What a law is described by.

use preslide::{Block, Sliding};

/// A law and what it is made of.
#[derive(Default)]
pub(crate) struct Law<'a> {
    /// Its name in model files; a row of measured costs begins with it.
    pub(crate) kind: &'static str,
    /// Its name in tables.
    pub(crate) name: String,
    /// Its parameters by their keys on a linear axis, but for those below; a file may leave damping out.
    pub(crate) scalars: Vec<(&'static str, &'a mut f64)>,
    /// Its blocks, where it has any.
    pub(crate) blocks: Option<&'a mut Vec<Block>>,
    /// Its Stribeck curve, where it has one.
    pub(crate) curve: Curve<'a>,
    /// A length over which the force changes (m), where a displacement is searched for.
    pub(crate) length: f64,
}

/// Whether a law slides along a Stribeck curve.
#[derive(Default)]
pub(crate) enum Curve<'a> {
    /// It has none.
    #[default]
    None,
    /// It has one, though it may be flat.
    Always(&'a mut Sliding),
    /// It is another law without.
    Optional(&'a mut Option<Sliding>),
}

impl<'a> Curve<'a> {
    /// The curve, where there is one.
    pub(crate) fn given(self) -> Option<&'a mut Sliding> {
        match self {
            Self::None => None,
            Self::Always(sliding) => Some(sliding),
            Self::Optional(sliding) => sliding.as_mut(),
        }
    }
}

/// The laws by their variants, each described once: the library's constructor, which is called here and written by `export`, and what [`Law`] says
/// of it. A constructor's arguments are fields, but for the units, which are last.
macro_rules! laws {
    ($sample_time:ident; $($model:pat => $law:ident $(of $blocks:ident)? ($($argument:expr),*) {
        kind: $kind:expr,
        name: $name:expr,
        scalars: [$($key:ident: $scalar:expr),*],
        $($part:ident: $of_it:expr,)*
    })*) => {
        impl FrictionModel {
            /// The law that it is of.
            #[allow(clippy::needless_update)] // some laws have all parts
            pub(crate) fn law(&mut self) -> Law<'_> {
                match self {
                    $($model => Law {
                        kind: $kind,
                        name: $name.to_string(),
                        $($part: $of_it,)*
                        scalars: vec![$((stringify!($key), $scalar)),*],
                        ..Law::default()
                    },)*
                }
            }

            /// Hands the library's model, in `units` and for ticks of `sample_time` (s), to `visitor`.
            ///
            /// # Errors
            /// [`ParamError`] where the library refuses a parameter.
            pub fn visit_in<S: Scalar + Send + 'static, V: Visitor<S>>(
                &self,
                $sample_time: f64,
                units: Units,
                visitor: V,
            ) -> Result<V::Outcome, ParamError> {
                #[allow(unused_variables)] // of the fields, some are told by which law it is
                match self.clone() {
                    $($model => laws!(@visit visitor, units, $law $(of $blocks)? ($($argument),*)),)*
                }
            }

            /// The library's type, and the names of what its constructor takes before the units.
            #[allow(unused_variables)] // fields are bound to be arguments, of which the names are told here
            pub fn constructor(&self) -> (&'static str, &'static [&'static str]) {
                match self {
                    $($model => (stringify!($law), &[$(stringify!($argument)),*]),)*
                }
            }
        }
    };
    (@visit $visitor:ident, $units:ident, $law:ident ($($argument:expr),*)) => {
        Ok($visitor.visit($law::<S>::try_new($($argument,)* $units)?))
    };
    (@visit $visitor:ident, $units:ident, $law:ident of $blocks:ident $arguments:tt) => {
        laws!(@sizes [1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16] $visitor, $units, $law of $blocks $arguments)
    };
    (@sizes [$($n:literal)*] $visitor:ident, $units:ident, $law:ident of $blocks:ident $arguments:tt) => {
        match $blocks.len() {
            $($n => {
                let mut array = [Block { stiffness: 0.0, weight: 0.0 }; $n];
                array.copy_from_slice(&$blocks);
                let $blocks = &array;
                laws!(@sized $visitor, $units, $law $arguments)
            })*
            other => Err(ParamError::new("number of blocks", other as f64, Bound::AtMost(MOST_BLOCKS as f64))),
        }
    };
    (@sized $visitor:ident, $units:ident, $law:ident ($($argument:expr),*)) => {
        Ok($visitor.visit($law::<_, S>::try_new($($argument,)* $units)?))
    };
}
pub(super) use laws;
