//! The play operator: what follows a value through a slack of half the width h, and stays until that has gone on by h.
//!
//! P_h(x) is where it was, moved as little as keeps it within h of x. Before the first value all is at 0.
//! Visintin, Differential Models of Hysteresis (1994), chapter III.

use super::dual::Dual;

/// P_h(x) at every value of a sequence. A value that is no number is passed over.
pub(super) fn following(half_width: Dual, values: impl Iterator<Item = Dual>) -> Vec<Dual> {
    let mut follows = Dual::constant(0.0);
    let next = |value: Dual| {
        if value.value.is_nan() {
            return value;
        }
        let (low, high) = (value - half_width, value + half_width);
        if follows.value < low.value {
            follows = low;
        } else if follows.value > high.value {
            follows = high;
        }
        follows
    };
    values.map(next).collect()
}
