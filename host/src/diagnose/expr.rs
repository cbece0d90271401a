//! Formulas of forces, evaluated along a recording and printed as code: what a file shows is what the code computes.

use std::fmt;
use std::ops::{Add, Mul};

/// What a force may depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Time (s).
    Time,
    /// Position (m or rad).
    Position,
    /// Velocity (m/s or rad/s).
    Velocity,
    /// Acceleration (m/s² or rad/s²).
    Acceleration,
    /// Travelled path (m or rad).
    Path,
    /// Temperature (°C).
    Temperature,
    /// Load (N).
    Load,
    /// Force of the correction's own blocks (N or N·m).
    Blocks,
    /// The recording's friction over its level (-).
    Direction,
    /// The same of the blocks that slip.
    Slipping,
}

impl Input {
    /// Its name in code.
    pub fn name(self) -> &'static str {
        match self {
            Self::Time => "t",
            Self::Position => "x",
            Self::Velocity => "v",
            Self::Acceleration => "a",
            Self::Path => "path",
            Self::Temperature => "temperature",
            Self::Load => "load",
            Self::Blocks => "blocks",
            Self::Direction => "direction",
            Self::Slipping => "slipping",
        }
    }
}

/// Functions that Python, C and MATLAB have under one name, or nearly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Function {
    /// `|a|`.
    Abs,
    /// `cos a`.
    Cos,
    /// `exp a`.
    Exp,
    /// `sin a`.
    Sin,
    /// `tanh a`.
    Tanh,
}

/// A formula.
#[derive(Clone, Debug)]
pub enum Expr {
    /// A constant.
    Number(f64),
    /// A signal.
    Input(Input),
    /// A function of a formula.
    Of(Function, Box<Expr>),
    /// A formula that is not negative, to a power.
    Power(Box<Expr>, f64),
    /// A sum.
    Sum(Box<Expr>, Box<Expr>),
    /// A product.
    Product(Box<Expr>, Box<Expr>),
}

impl Expr {
    /// A function of it.
    pub fn of(self, function: Function) -> Self {
        Self::Of(function, Box::new(self))
    }

    /// To a power.
    pub fn power(self, exponent: f64) -> Self {
        Self::Power(Box::new(self), exponent)
    }

    /// Its value where a signal is `at` it.
    pub fn value(&self, at: &impl Fn(Input) -> f64) -> f64 {
        match self {
            Self::Number(number) => *number,
            Self::Input(input) => at(*input),
            Self::Of(function, of) => {
                let value = of.value(at);
                match function {
                    Function::Abs => value.abs(),
                    Function::Cos => value.cos(),
                    Function::Exp => value.exp(),
                    Function::Sin => value.sin(),
                    Function::Tanh => value.tanh(),
                }
            }
            Self::Power(of, exponent) => of.value(at).powf(*exponent),
            Self::Sum(a, b) => a.value(at) + b.value(at),
            Self::Product(a, b) => a.value(at) * b.value(at),
        }
    }

    /// Whether it depends on a signal.
    pub fn uses(&self, input: Input) -> bool {
        match self {
            Self::Number(_) => false,
            Self::Input(own) => *own == input,
            Self::Of(_, of) | Self::Power(of, _) => of.uses(input),
            Self::Sum(a, b) | Self::Product(a, b) => a.uses(input) || b.uses(input),
        }
    }
}

impl Add for Expr {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::Sum(Box::new(self), Box::new(other))
    }
}

impl Mul<Expr> for f64 {
    type Output = Expr;
    fn mul(self, other: Expr) -> Expr {
        Expr::Number(self) * other
    }
}

impl Mul for Expr {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self::Product(Box::new(self), Box::new(other))
    }
}

impl From<Input> for Expr {
    fn from(input: Input) -> Self {
        Self::Input(input)
    }
}

/// As Python has it; C calls `abs` `fabs`, MATLAB `pow` `power`.
impl fmt::Display for Expr {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Number(number) if *number < 0.0 => write!(f, "({number:?})"),
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Input(input) => f.write_str(input.name()),
            Self::Of(function, of) => {
                let name = match function {
                    Function::Abs => "abs",
                    Function::Cos => "cos",
                    Function::Exp => "exp",
                    Function::Sin => "sin",
                    Function::Tanh => "tanh",
                };
                write!(f, "{name}({of})")
            }
            Self::Power(of, exponent) => write!(f, "pow({of}, {exponent:?})"),
            Self::Sum(a, b) => write!(f, "({a} + {b})"),
            Self::Product(a, b) => write!(f, "{a}*{b}"),
        }
    }
}
