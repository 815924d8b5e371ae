//! Formulas: the `expression` of an own effect in a case file.
//!
//! - [`parse`]: text to a tree, by a grammar that holds arithmetic and a dozen functions and nothing else;
//! - [`value`]: the tree's value in dual numbers;
//! - `dimension`: whether the stated units of its parameters make of it what its port adds to;
//! - here: [`Formula`], the own effect made of it.

mod dimension;
pub mod parse;
pub mod value;

use cbpt_core::InvalidInput;
use cbpt_core::effect::dual::Dual;
use cbpt_core::effect::own::{AddsTo, At, OwnEffect, OwnParameter, Variable};

pub use parse::Wrong;
use value::Node;

/// An own effect whose value is a formula.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    id: String,
    adds_to: AddsTo,
    text: String,
    tree: Node,
    parameters: Vec<OwnParameter>,
}

impl Formula {
    /// Reads the text.
    ///
    /// # Errors
    /// [`Wrong`] names the place in the text and what is allowed there.
    pub fn new(
        id: impl Into<String>,
        adds_to: AddsTo,
        text: impl Into<String>,
        parameters: Vec<OwnParameter>,
    ) -> Result<Self, Wrong> {
        let text = text.into();
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        let tree = parse::tree(&text, &names)?;
        if matches!(adds_to, AddsTo::Torque | AddsTo::Preload) && tree.uses(Variable::Angle) {
            let character = text.find("alpha_rad").map_or(1, |place| place + 1);
            let problem = "alpha_rad follows from the load, so it is not known at the port load".into();
            return Err(Wrong { character, problem, name: String::new(), known: Vec::new() });
        }
        dimension::check(&tree, &text, &parameters, adds_to)?;
        Ok(Self { id: id.into(), adds_to, text, tree, parameters })
    }

    /// The formula as it was written.
    pub fn text(&self) -> &str {
        &self.text
    }
}

impl OwnEffect for Formula {
    fn id(&self) -> &str {
        &self.id
    }

    fn adds_to(&self) -> AddsTo {
        self.adds_to
    }

    fn parameters(&self) -> &[OwnParameter] {
        &self.parameters
    }

    fn uses(&self, variable: Variable) -> bool {
        self.tree.uses(variable)
    }

    fn values(&self, own: &[Dual], rows: &[At<'_>]) -> Result<Vec<Dual>, InvalidInput> {
        Ok(rows.iter().map(|at| self.tree.value(own, at)).collect())
    }
}
