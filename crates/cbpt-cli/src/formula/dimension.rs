//! Whether the units of an own effect fit: what its parameters and variables make together must be what its port adds to.
//!
//! Only a stated unit can be wrong. A parameter without one, a number and a power with a free exponent have whatever dimension
//! is needed, and so has what they are multiplied with; a formula without stated units is in SI, as the variables are.

use cbpt_core::effect::own::{AddsTo, OwnParameter};
use cbpt_core::units::compound;
use cbpt_core::units::dimension::Dimension;

use super::Wrong;
use super::value::{Function, Infix, Node, What};

/// Refuses the first unit that does not fit.
///
/// # Errors
/// [`Wrong`] names the part of the formula, its unit, and the unit in which to give a parameter.
pub fn check(tree: &Node, text: &str, parameters: &[OwnParameter], adds_to: AddsTo) -> Result<(), Wrong> {
    let dimension = |parameter: &OwnParameter| {
        Some(compound::read(unit_of(parameter)).ok()?.dimension).filter(|_| !unit_of(parameter).is_empty())
    };
    let dimensions = parameters.iter().map(dimension).collect();
    let needed = match adds_to {
        AddsTo::Torque => "a term of torque_Nm is a torque",
        AddsTo::Preload => "a term of preload_N is a force",
        AddsTo::Series => "a series term is an angle",
        AddsTo::Reading => "a reading term is an angle",
    };
    Checker { text, parameters, dimensions }.expect(tree, adds_to.quantity().dimension(), needed)
}

/// The unit as it was stated.
fn unit_of(parameter: &OwnParameter) -> &str {
    if parameter.stated.is_empty() { &parameter.unit } else { &parameter.stated }
}

struct Checker<'a> {
    text: &'a str,
    parameters: &'a [OwnParameter],
    /// Of each parameter; `None` without a stated unit.
    dimensions: Vec<Option<Dimension>>,
}

impl Checker<'_> {
    /// Refuses a part that cannot be `wanted`, term by term; `needed` says why it should.
    fn expect(&self, node: &Node, wanted: Dimension, needed: &str) -> Result<(), Wrong> {
        if let Some(terms) = alike(node) {
            return terms.into_iter().try_for_each(|term| self.expect(term, wanted, needed));
        }
        match (self.of(node)?, self.culprit(node)) {
            (Some(found), Some(culprit)) if !found.fits(wanted) => {
                Err(self.wrong(node, found, wanted, culprit, needed))
            }
            _ => Ok(()),
        }
    }

    /// The dimension of a part; `None` where it cannot be decided.
    fn of(&self, node: &Node) -> Result<Option<Dimension>, Wrong> {
        if let Some(terms) = alike(node) {
            return self.shared(&terms);
        }
        let number = Some(Dimension::NUMBER);
        Ok(match &node.what {
            What::Number(_) | What::Minus(_) => None,
            What::Parameter(place) => self.dimensions[*place],
            What::Variable(variable) => Some(variable.quantity().dimension()),
            What::Infix(Infix::Power, parts) => {
                self.expect(&parts[1], Dimension::NUMBER, "an exponent is a plain number")?;
                let base = self.of(&parts[0])?;
                let power = |base: Dimension| match parts[1].constant() {
                    Some(power) => Some(base.power(power)),
                    None => Some(base).filter(|base| base.is_number()),
                };
                base.and_then(power)
            }
            What::Infix(infix, parts) => {
                let (left, right) = (self.of(&parts[0])?, self.of(&parts[1])?);
                let joined = if *infix == Infix::Divide { Dimension::over } else { Dimension::times };
                left.zip(right).map(|(left, right)| joined(left, right))
            }
            What::Call(Function::Sqrt, parts) => self.of(&parts[0])?.map(|inside| inside.power(0.5)),
            What::Call(Function::Sign, parts) => self.of(&parts[0]).map(|_| number)?,
            What::Call(function, parts) => {
                let needed = format!("the argument of {} is a plain number or an angle", function.name());
                self.expect(&parts[0], Dimension::NUMBER, &needed)?;
                number
            }
        })
    }

    /// The dimension of parts that are added or compared, so of each of them.
    fn shared(&self, terms: &[&Node]) -> Result<Option<Dimension>, Wrong> {
        let mut shared: Option<(&Node, Dimension)> = None;
        for term in terms {
            let Some(found) = self.of(term)? else { continue };
            let Some((first, wanted)) = shared else {
                shared = Some((term, found));
                continue;
            };
            // What has no stated unit is right as it stands.
            let (term, found, beside, wanted) = match self.culprit(term) {
                Some(_) => (*term, found, first, wanted),
                None => (first, wanted, *term, found),
            };
            if !found.fits(wanted) {
                let needed =
                    format!("it stands beside {}, which is {}", self.words(beside), wanted.in_words());
                self.expect(term, wanted, &needed)?;
                return Ok(None);
            }
        }
        Ok(shared.map(|(_, dimension)| dimension))
    }

    /// The first parameter with a stated unit that decides the dimension of a part, and its power there.
    fn culprit(&self, node: &Node) -> Option<(usize, f64)> {
        let raised = |node: &Node, by: f64| self.culprit(node).map(|(place, power)| (place, power * by));
        if let Some(terms) = alike(node) {
            return terms.into_iter().find_map(|term| self.culprit(term));
        }
        match &node.what {
            What::Parameter(place) => self.dimensions[*place].map(|_| (*place, 1.0)),
            What::Infix(Infix::Power, parts) => {
                raised(&parts[0], parts[1].constant().filter(|power| *power != 0.0)?)
            }
            What::Infix(infix, parts) => {
                let below = if *infix == Infix::Divide { -1.0 } else { 1.0 };
                self.culprit(&parts[0]).or_else(|| raised(&parts[1], below))
            }
            What::Call(Function::Sqrt, parts) => raised(&parts[0], 0.5),
            _ => None,
        }
    }

    fn wrong(
        &self,
        node: &Node,
        found: Dimension,
        wanted: Dimension,
        (place, power): (usize, f64),
        needed: &str,
    ) -> Wrong {
        let parameter = &self.parameters[place];
        let (name, unit, words) = (&parameter.name, unit_of(parameter), self.words(node));
        let so = if words == name { String::new() } else { format!(", so {words} is {}", found.in_words()) };
        let own = self.dimensions[place].unwrap_or(Dimension::NUMBER);
        let right = own.times(wanted.over(found).power(1.0 / power));
        let give = if right.is_number() { "as a plain number".into() } else { right.in_words() };
        Wrong::at(self.text, node.at.start, format!("{name} is in {unit}{so}; {needed}: give {name} {give}"))
    }

    /// A part as it is written.
    fn words(&self, node: &Node) -> &str {
        self.text.get(node.at.clone()).unwrap_or_default()
    }
}

/// The parts that must have the dimension of the whole; `None` where it follows in another way.
fn alike(node: &Node) -> Option<Vec<&Node>> {
    match &node.what {
        What::Minus(part) => Some(vec![part]),
        What::Infix(Infix::Add | Infix::Subtract, parts) => Some(parts.iter().collect()),
        What::Call(Function::Abs | Function::Min | Function::Max, parts) => Some(parts.iter().collect()),
        _ => None,
    }
}
