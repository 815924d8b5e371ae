//! Units made of those of the table: `arcsec/(N m)`, `rad/(N m)^3`, `lbf in/deg`.
//!
//! - [`read`]: a unit as people write it, as its size in SI, the SI unit in the same form, and its dimension.
//!
//! Products stand with a blank, `*`, a dot or a hyphen, quotients with `/` from left to right, powers with `^`. Words that
//! together are a unit of the table are one: `rad/N m` is rad/(N m).

use super::dimension::Dimension;
use super::{Quantity, Unit, all};

/// A unit that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Compound {
    /// SI value of one unit.
    pub size: f64,
    /// The SI unit in the same form: `rad/(N m)` of `arcsec/(N m)`.
    pub si: String,
    /// What it is a product of.
    pub dimension: Dimension,
}

/// Of a plain number.
const PLAIN: Compound = Compound { size: 1.0, si: String::new(), dimension: Dimension::NUMBER };

/// Most words that are one unit: `lbf in`, `in lbf`.
const MOST_WORDS: usize = 2;
/// What counts one each and has no unit.
const COUNTS: [&str; 3] = ["1", "cycle", "cycles"];

/// Reads a unit; empty for a plain number.
///
/// # Errors
/// What is no unit, in words that a message can hold.
pub fn read(text: &str) -> Result<Compound, String> {
    if text.trim().is_empty() {
        return Ok(PLAIN);
    }
    let parts = parts(text);
    let alone: Vec<&str> = parts.iter().filter_map(Part::word).collect();
    if alone.len() == parts.len() && alone.len() == 1 && known(alone[0]).is_some_and(|u| u.offset != 0.0) {
        return Err(format!("{} has a zero of its own; differences of temperature are in K", text.trim()));
    }
    let mut reader = Reader { parts: &parts, at: 0 };
    let found = reader.quotient()?;
    match reader.next() {
        None => Ok(found),
        Some(part) => Err(format!("{part} stands where no part of a unit can")),
    }
}

/// The unit of the table with this symbol, written form or spelling.
fn known(word: &str) -> Option<&'static Unit> {
    let squeezed = |text: &str| text.replace([' ', '_'], "");
    let is_it = |unit: &&Unit| {
        unit.quantity != Quantity::Number
            && (unit.symbol == word || squeezed(unit.written) == word || unit.spellings.contains(&word))
    };
    all().find(is_it)
}

#[derive(Debug, Clone, PartialEq)]
enum Part {
    Word(String),
    Sign(char),
    Power(f64),
}

impl Part {
    fn word(&self) -> Option<&str> {
        if let Self::Word(word) = self { Some(word) } else { None }
    }
}

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Word(word) => write!(f, "{word:?}"),
            Self::Sign(sign) => write!(f, "{sign:?}"),
            Self::Power(power) => write!(f, "\"^{power}\""),
        }
    }
}

/// Words, signs and powers; what joins the factors of a product is left out.
fn parts(text: &str) -> Vec<Part> {
    let text = text.replace("**", "^").replace('²', "^2").replace('³', "^3").replace('µ', "μ");
    let signs: Vec<char> = text.chars().collect();
    let mut found = Vec::new();
    let mut at = 0;
    let run = |from: usize, of: &dyn Fn(char) -> bool| {
        signs[from..].iter().copied().take_while(|sign| of(*sign)).collect::<String>()
    };
    while at < signs.len() {
        let sign = signs[at];
        let power = run(at + 1, &|c| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | ' '));
        if let Some(value) = (sign == '^').then(|| power.trim().parse().ok()).flatten() {
            found.push(Part::Power(value));
            at += 1 + power.trim_end().chars().count();
        } else if matches!(sign, '(' | ')' | '/' | '^') {
            found.push(Part::Sign(sign));
            at += 1;
        } else if sign.is_whitespace() || matches!(sign, '*' | '·' | '⋅' | '×' | '.' | '-') {
            at += 1;
        } else {
            let word = run(at, &|c| !c.is_whitespace() && !"()/^*·⋅×.-".contains(c));
            at += word.chars().count();
            found.push(Part::Word(word));
        }
    }
    found
}

struct Reader<'a> {
    parts: &'a [Part],
    at: usize,
}

impl Reader<'_> {
    fn next(&self) -> Option<&Part> {
        self.parts.get(self.at)
    }

    fn takes(&mut self, sign: char) -> bool {
        let there = self.next() == Some(&Part::Sign(sign));
        self.at += usize::from(there);
        there
    }

    fn quotient(&mut self) -> Result<Compound, String> {
        let mut found = self.product()?;
        while self.takes('/') {
            // One factor alone stands below the line, and what follows it above: rad/s/(N m), rad/(N m) N.
            let below = self.factor()?;
            found = over(&found, &below);
            while matches!(self.next(), Some(Part::Word(_) | Part::Sign('('))) {
                found = times(&found, &self.factor()?);
            }
        }
        Ok(found)
    }

    fn product(&mut self) -> Result<Compound, String> {
        let mut found = self.factor()?;
        while matches!(self.next(), Some(Part::Word(_) | Part::Sign('('))) {
            found = times(&found, &self.factor()?);
        }
        Ok(found)
    }

    fn factor(&mut self) -> Result<Compound, String> {
        let inner = if self.takes('(') {
            let inner = self.quotient()?;
            if !self.takes(')') {
                return Err("a bracket is not closed".into());
            }
            inner
        } else {
            self.unit()?
        };
        let Some(Part::Power(power)) = self.next().cloned() else { return Ok(inner) };
        self.at += 1;
        let si = if inner.si.contains([' ', '/', '^']) { format!("({})", inner.si) } else { inner.si };
        let si = if si.is_empty() { si } else { format!("{si}^{power}") };
        Ok(Compound { size: inner.size.powf(power), si, dimension: inner.dimension.power(power) })
    }

    /// A unit of the table, of as many words as make one.
    fn unit(&mut self) -> Result<Compound, String> {
        for count in (1..=MOST_WORDS).rev() {
            let words: Option<Vec<&str>> = self
                .parts
                .get(self.at..self.at + count)
                .and_then(|some| some.iter().map(Part::word).collect());
            let Some(words) = words else { continue };
            if let Some(unit) = known(&words.concat()) {
                self.at += count;
                let (si, dimension) = (unit.quantity.si().written.into(), unit.quantity.dimension());
                return Ok(Compound { size: unit.size(), si, dimension });
            }
        }
        match self.next() {
            Some(Part::Word(word)) if COUNTS.contains(&word.as_str()) => {
                self.at += 1;
                Ok(PLAIN)
            }
            Some(part) => Err(format!("{part} is no unit that is known")),
            None => Err("the unit ends where another part is needed".into()),
        }
    }
}

fn times(one: &Compound, other: &Compound) -> Compound {
    let blank = if one.si.is_empty() || other.si.is_empty() { "" } else { " " };
    let si = format!("{}{blank}{}", one.si, other.si);
    Compound { size: one.size * other.size, si, dimension: one.dimension.times(other.dimension) }
}

fn over(one: &Compound, other: &Compound) -> Compound {
    let (si, dimension) = (divided(&one.si, &other.si), one.dimension.over(other.dimension));
    Compound { size: one.size / other.size, si, dimension }
}

fn divided(above: &str, below: &str) -> String {
    let above = if above.is_empty() { "1" } else { above };
    match below {
        "" if above == "1" => String::new(),
        "" => above.into(),
        below if below.contains([' ', '/']) && !below.starts_with('(') => format!("{above}/({below})"),
        below => format!("{above}/{below}"),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::units::ARCSEC;

    fn is(text: &str, size: f64, si: &str) {
        let found = read(text).unwrap();
        assert!((found.size / size - 1.0).abs() < 1e-14, "{text}: {}", found.size);
        assert_eq!(found.si, si, "{text}");
    }

    #[test]
    fn a_unit_is_its_size_and_the_unit_of_si_in_the_same_form() {
        for (text, size, si) in [
            ("", 1.0, ""),
            ("1", 1.0, ""),
            ("rad", 1.0, "rad"),
            ("arcsec/(N m)", ARCSEC, "rad/(N m)"),
            ("arcsec / (N*m)", ARCSEC, "rad/(N m)"),
            ("arcsec/N m", ARCSEC, "rad/(N m)"),
            ("arcsec_per_Nm", ARCSEC, "rad/(N m)"),
            ("rad/(N m)^3", 1.0, "rad/(N m)^3"),
            ("µrad/(kN·m)²", 1e-12, "rad/(N m)^2"),
            ("rad/(N m)*N", 1.0, "rad/(N m) N"),
            ("rad/(N m)/h", 1.0 / 3600.0, "rad/(N m)/s"),
            ("1/min", 1.0 / 60.0, "1/s"),
            ("arcsec/cycle", ARCSEC, "rad"),
            ("lbf in", 0.112_984_829_027_616_7, "N m"),
            ("arcsec/(lbf in)", ARCSEC / 0.112_984_829_027_616_7, "rad/(N m)"),
            ("N^0.5", 1.0, "N^0.5"),
            ("mm^-1", 1e3, "m^-1"),
            ("um/K", 1e-6, "m/K"),
        ] {
            is(text, size, si);
        }
    }

    #[test]
    fn what_is_no_unit_is_refused_with_its_place() {
        for (text, told) in [
            ("arcsecs per week", "\"per\" is no unit"),
            ("furlong", "\"furlong\" is no unit"),
            ("rad/(N m", "a bracket is not closed"),
            ("rad)", "')' stands where"),
            ("rad/", "ends where"),
            ("degC", "differences of temperature are in K"),
        ] {
            let found = read(text).unwrap_err();
            assert!(found.contains(told), "{text}: {found}");
        }
    }
}
