//! A small picture of bars as SVG, for notebooks: how loads are shared among meshing points.
//!
//! - [`svg`]: groups of bars above one line, each with its name and its largest value.

use std::fmt::Write as _;

use crate::report::{escaped, six_digits};

const WIDTH: f64 = 320.0;
const HEIGHT: f64 = 96.0;
/// Space above the bars for the names.
const HEAD: f64 = 18.0;

/// One picture for each group: its name, and a bar for each number; empty where there is no number above 0.
pub(crate) fn svg(groups: &[(String, Vec<f64>)], unit: &str) -> String {
    groups.iter().map(|(name, values)| one(name, values, unit)).collect()
}

fn one(name: &str, values: &[f64], unit: &str) -> String {
    let most = values.iter().copied().fold(0.0, f64::max);
    if most <= 0.0 {
        return String::new();
    }
    let (width, floor) = (WIDTH / values.len() as f64, HEIGHT - 1.0);
    let mut drawn = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" role=\"img\" \
         style=\"background:#fff;margin-right:1em\"><text x=\"0\" y=\"12\" font-size=\"11\">{}, up to {} {}</text>",
        escaped(name),
        six_digits(most),
        escaped(unit)
    );
    for (place, value) in values.iter().enumerate() {
        let height = (value / most * (floor - HEAD)).max(0.0);
        let _ = write!(
            drawn,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{height:.1}\" fill=\"#0072B2\"/>",
            place as f64 * width,
            floor - height,
            (0.8 * width).max(0.5),
        );
    }
    let _ = write!(drawn, "<path d=\"M0 {floor}H{WIDTH}\" stroke=\"#444\"/></svg>");
    drawn
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_is_a_bar_as_high_as_its_share_and_names_are_escaped() {
        let drawn = svg(&[("a < b".into(), vec![2.0, 0.0, 4.0]), ("none".into(), vec![0.0])], "N");
        assert_eq!((drawn.matches("<svg").count(), drawn.matches("<rect").count()), (1, 3));
        assert!(drawn.contains("a &lt; b, up to 4 N"));
        let heights = ["height=\"38.5\"", "height=\"0.0\"", "height=\"77.0\""];
        assert!(heights.iter().all(|height| drawn.contains(height)), "{drawn}");
    }
}
