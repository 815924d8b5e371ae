//! A formula's tree and its value in dual numbers, so that slopes are exact.

use std::ops::Range;

use cbpt_core::effect::dual::Dual;
use cbpt_core::effect::own::{At, Variable};

/// A part of a formula, and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// What it is.
    pub what: What,
    /// Its bytes in the text.
    pub at: Range<usize>,
}

/// What a part of a formula is.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// A number.
    Number(f64),
    /// A parameter by its place.
    Parameter(usize),
    /// A variable.
    Variable(Variable),
    /// A change of sign.
    Minus(Box<Node>),
    /// Two parts with a sign between them.
    Infix(Infix, Box<[Node; 2]>),
    /// A function of one or two parts.
    Call(Function, Vec<Node>),
}

/// A sign between two parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the words say it
pub enum Infix {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

/// A function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the table says it
pub enum Function {
    Sin,
    Cos,
    Tan,
    Atan,
    Tanh,
    Exp,
    Log,
    Sqrt,
    Abs,
    Sign,
    Min,
    Max,
}

/// Every function: its name and how many arguments it takes.
pub const FUNCTIONS: [(Function, &str, usize); 12] = [
    (Function::Sin, "sin", 1),
    (Function::Cos, "cos", 1),
    (Function::Tan, "tan", 1),
    (Function::Atan, "atan", 1),
    (Function::Tanh, "tanh", 1),
    (Function::Exp, "exp", 1),
    (Function::Log, "log", 1),
    (Function::Sqrt, "sqrt", 1),
    (Function::Abs, "abs", 1),
    (Function::Sign, "sign", 1),
    (Function::Min, "min", 2),
    (Function::Max, "max", 2),
];

impl Function {
    /// The function of a name.
    pub fn find(name: &str) -> Option<Self> {
        FUNCTIONS.iter().find(|(_, known, _)| *known == name).map(|(function, ..)| *function)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|(function, ..)| *function == self).map_or("", |(_, name, _)| name)
    }

    /// How many arguments it takes.
    pub fn arguments(self) -> usize {
        FUNCTIONS.iter().find(|(function, ..)| *function == self).map_or(1, |(.., count)| *count)
    }

    fn value(self, x: Dual, other: Option<Dual>) -> Dual {
        let v = x.value;
        match self {
            Self::Sin => x.chain_where_any(v.sin(), v.cos()),
            Self::Cos => x.chain_where_any(v.cos(), -v.sin()),
            Self::Tan => x.chain_where_any(v.tan(), 1.0 + v.tan().powi(2)),
            Self::Atan => x.chain_where_any(v.atan(), 1.0 / (1.0 + v * v)),
            Self::Tanh => x.chain_where_any(v.tanh(), 1.0 - v.tanh().powi(2)),
            Self::Exp => x.chain_where_any(v.exp(), v.exp()),
            Self::Log => x.chain_where_any(v.ln(), 1.0 / v),
            Self::Sqrt => x.chain_where_any(v.sqrt(), 0.5 / v.sqrt()),
            Self::Abs => x.abs(),
            // At 0 it is 0, as in numpy; not finite stays so.
            Self::Sign => Dual::constant(if v == 0.0 {
                0.0
            } else if v.is_nan() {
                v
            } else {
                v.signum()
            }),
            Self::Min | Self::Max => {
                let y = other.unwrap_or(x);
                // What is not finite must not be lost in a comparison.
                let first = if self == Self::Min { v <= y.value } else { v >= y.value };
                if v.is_nan() || first { x } else { y }
            }
        }
    }
}

impl What {
    /// The part that stands at these bytes.
    pub fn at(self, at: Range<usize>) -> Node {
        Node { what: self, at }
    }
}

impl Infix {
    fn value(self, x: Dual, y: Dual) -> Dual {
        match self {
            Self::Add => x + y,
            Self::Subtract => x - y,
            Self::Multiply => x * y,
            Self::Divide => x.quotient(&y),
            Self::Power => x.power(&y),
        }
    }
}

impl Node {
    /// Its value at a row, given the parameters.
    pub fn value(&self, own: &[Dual], at: &At<'_>) -> Dual {
        match &self.what {
            What::Number(number) => Dual::constant(*number),
            What::Parameter(place) => own[*place],
            What::Variable(variable) => at.get(*variable),
            What::Minus(part) => -part.value(own, at),
            What::Infix(infix, parts) => infix.value(parts[0].value(own, at), parts[1].value(own, at)),
            What::Call(function, parts) => {
                let mut values = parts.iter().map(|part| part.value(own, at));
                let first = values.next().unwrap_or(Dual::constant(f64::NAN));
                function.value(first, values.next())
            }
        }
    }

    /// Its value where it depends on nothing.
    pub fn constant(&self) -> Option<f64> {
        let of = |part: &Self| part.constant().map(Dual::constant);
        Some(match &self.what {
            What::Number(number) => *number,
            What::Parameter(_) | What::Variable(_) => return None,
            What::Minus(part) => -part.constant()?,
            What::Infix(infix, parts) => infix.value(of(&parts[0])?, of(&parts[1])?).value,
            What::Call(function, parts) => {
                let first = of(parts.first()?)?;
                let second = match parts.get(1) {
                    Some(part) => Some(of(part)?),
                    None => None,
                };
                function.value(first, second).value
            }
        })
    }

    /// Whether it depends on a variable.
    pub fn uses(&self, variable: Variable) -> bool {
        match &self.what {
            What::Number(_) | What::Parameter(_) => false,
            What::Variable(found) => *found == variable,
            What::Minus(part) => part.uses(variable),
            What::Infix(_, parts) => parts.iter().any(|part| part.uses(variable)),
            What::Call(_, parts) => parts.iter().any(|part| part.uses(variable)),
        }
    }
}
