//! Text to a tree. pest reads by `grammar.pest`; here are precedence, names, and what is told of a mistake.

use std::sync::LazyLock;

use cbpt_core::effect::own::{VARIABLES, Variable};
use pest::Parser;
use pest::error::InputLocation;
use pest::iterators::{Pair, Pairs};
use pest::pratt_parser::{Assoc, Op, PrattParser};

use super::value::{FUNCTIONS, Function, Infix, Node, What};

use grammar::{Grammar, Rule};

#[allow(missing_docs)] // made by the derive
mod grammar {
    #[derive(pest_derive::Parser)]
    #[grammar = "formula/grammar.pest"]
    pub struct Grammar;
}

/// Characters of a formula: a term of a model is a line or two.
pub const LONGEST: usize = 1000;
/// Brackets inside each other.
pub const DEEPEST: usize = 32;

/// What is wrong with a formula, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// Character of the formula, from 1.
    pub character: usize,
    /// What is wrong.
    pub problem: String,
    /// A name that nothing has; empty where the mistake is another.
    pub name: String,
    /// The names that there are in its place.
    pub known: Vec<String>,
}

/// As arithmetic is written: -x^2 is -(x^2), and 2^3^2 is 2^9.
static PRECEDENCE: LazyLock<PrattParser<Rule>> = LazyLock::new(|| {
    PrattParser::new()
        .op(Op::infix(Rule::add, Assoc::Left) | Op::infix(Rule::subtract, Assoc::Left))
        .op(Op::infix(Rule::multiply, Assoc::Left) | Op::infix(Rule::divide, Assoc::Left))
        .op(Op::prefix(Rule::minus) | Op::prefix(Rule::plus))
        .op(Op::infix(Rule::power, Assoc::Right))
});

/// Reads a formula; `parameters` are the names of its parameters.
pub fn tree(text: &str, parameters: &[&str]) -> Result<Node, Wrong> {
    bounded(text)?;
    let mut found = Grammar::parse(Rule::whole, text).map_err(|error| syntax(text, &error))?;
    let wrong = || Wrong::at(text, 0, "nothing to compute");
    let whole = found.next().ok_or_else(wrong)?;
    Reader { text, parameters }.sum(whole.into_inner())
}

impl Wrong {
    pub(super) fn at(text: &str, byte: usize, problem: impl Into<String>) -> Self {
        let character = text.get(..byte).map_or(1, |before| before.chars().count() + 1);
        Self { character, problem: problem.into(), name: String::new(), known: Vec::new() }
    }
}

/// Refuses what no one has written as a term of a model, before it is read.
fn bounded(text: &str) -> Result<(), Wrong> {
    if text.chars().count() > LONGEST {
        return Err(Wrong::at(text, 0, format!("longer than {LONGEST} characters")));
    }
    let mut depth = 0_usize;
    for (byte, character) in text.char_indices() {
        match character {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > DEEPEST {
            return Err(Wrong::at(text, byte, format!("more than {DEEPEST} brackets inside each other")));
        }
    }
    Ok(())
}

fn syntax(text: &str, error: &pest::error::Error<Rule>) -> Wrong {
    let byte = match error.location {
        InputLocation::Pos(byte) | InputLocation::Span((byte, _)) => byte,
    };
    let rest = text.get(byte..).unwrap_or_default();
    let found = rest.chars().next().map_or("the end".into(), |character| format!("`{character}`"));
    let operand = |rule: &Rule| matches!(rule, Rule::sum | Rule::number | Rule::name | Rule::call);
    let wants_operand = match &error.variant {
        pest::error::ErrorVariant::ParsingError { positives, .. } => positives.iter().any(operand),
        pest::error::ErrorVariant::CustomError { .. } => false,
    };
    let open = text[..byte].matches('(').count() > text[..byte].matches(')').count();
    let expected = match (wants_operand, open) {
        (true, _) => "a number, a name or an opening bracket",
        (false, true) => "+, -, *, /, ^, a comma or a closing bracket",
        (false, false) => "+, -, *, /, ^ or the end",
    };
    Wrong::at(text, byte, format!("found {found}, expected {expected}"))
}

struct Reader<'a> {
    text: &'a str,
    parameters: &'a [&'a str],
}

impl Reader<'_> {
    fn sum(&self, parts: Pairs<'_, Rule>) -> Result<Node, Wrong> {
        PRECEDENCE
            .map_primary(|part| self.part(part))
            .map_prefix(|sign, node| {
                let node = node?;
                let at = sign.as_span().start()..node.at.end;
                Ok(if sign.as_rule() == Rule::minus { What::Minus(Box::new(node)).at(at) } else { node })
            })
            .map_infix(|left, sign, right| {
                let byte = sign.as_span().start();
                let infix = match sign.as_rule() {
                    Rule::add => Infix::Add,
                    Rule::subtract => Infix::Subtract,
                    Rule::multiply => Infix::Multiply,
                    Rule::divide => Infix::Divide,
                    _ => Infix::Power,
                };
                let (left, right) = (left?, right?);
                let at = left.at.start..right.at.end;
                self.finite(What::Infix(infix, Box::new([left, right])).at(at), byte)
            })
            .parse(parts)
    }

    fn part(&self, part: Pair<'_, Rule>) -> Result<Node, Wrong> {
        let span = part.as_span();
        let (byte, at) = (span.start(), span.start()..span.end());
        match part.as_rule() {
            Rule::number => {
                let value = part.as_str().parse().ok().filter(|value: &f64| value.is_finite());
                let wrong = || Wrong::at(self.text, byte, format!("{} is no finite number", part.as_str()));
                value.map(|value| What::Number(value).at(at)).ok_or_else(wrong)
            }
            Rule::name => Ok(self.name(part.as_str(), byte)?.at(at)),
            Rule::call => self.finite(self.call(part.into_inner(), byte)?.at(at), byte),
            // With its brackets, where it has some.
            _ => Ok(Node { at, ..self.sum(part.into_inner())? }),
        }
    }

    fn name(&self, name: &str, byte: usize) -> Result<What, Wrong> {
        if let Some(place) = self.parameters.iter().position(|known| *known == name) {
            return Ok(What::Parameter(place));
        }
        if name == "pi" {
            return Ok(What::Number(std::f64::consts::PI));
        }
        if let Some(variable) = Variable::find(name) {
            return Ok(What::Variable(variable));
        }
        if Function::find(name).is_some() {
            return Err(Wrong::at(
                self.text,
                byte,
                format!("the function {name} needs brackets, {name}(...)"),
            ));
        }
        let variables = VARIABLES.iter().map(|(_, name, _)| *name);
        let known = self.parameters.iter().copied().chain(variables).chain(["pi"]);
        let wrong = Wrong::at(self.text, byte, format!("no parameter or variable is named {name}"));
        Err(Wrong { name: name.into(), known: known.map(str::to_owned).collect(), ..wrong })
    }

    /// Refuses a constant part that is not finite: the whole would not be either, or would lose the part unseen.
    fn finite(&self, node: Node, byte: usize) -> Result<Node, Wrong> {
        match node.constant() {
            Some(value) if !value.is_finite() => {
                Err(Wrong::at(self.text, byte, format!("makes a constant that is not finite ({value})")))
            }
            _ => Ok(node),
        }
    }

    fn call(&self, mut parts: Pairs<'_, Rule>, byte: usize) -> Result<What, Wrong> {
        let name = parts.next().map(|name| name.as_str()).unwrap_or_default();
        let Some(function) = Function::find(name) else {
            let known = FUNCTIONS.iter().map(|(_, name, _)| (*name).to_owned()).collect();
            let wrong = Wrong::at(self.text, byte, format!("no function is named {name}"));
            return Err(Wrong { name: name.into(), known, ..wrong });
        };
        let given: Vec<Node> = parts.map(|part| self.sum(part.into_inner())).collect::<Result<_, _>>()?;
        let wanted = function.arguments();
        if given.len() == wanted {
            return Ok(What::Call(function, given));
        }
        let problem = format!(
            "{name} takes {wanted} argument{}, not {}",
            ["s", ""][usize::from(wanted == 1)],
            given.len()
        );
        Err(Wrong::at(self.text, byte, problem))
    }
}
