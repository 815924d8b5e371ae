//! Preload lost with time.
//!
//! N_Z -> N_Z (1 - w t - s (t/T)^p - b (1 - exp(-t/tau)) - r ln(1 + t_run/tau_r)), t since the table's first reading. Steady wear takes a
//! share of the preload in proportion to time; the wear of surfaces that run in slows down (p < 1), as they come to bear on more of their
//! asperities; joints that seat under their screws lose it and then hold; springs, seals and polymers relax after each setting, with the
//! logarithm of the time since the run began.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "wear",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::BallDrives,
    equation: "N_Z -> N_Z (1 - w t - s (t/T)^p - b (1 - exp(-t/tau)) - r ln(1 + t_run/tau_r)), where t is the time since the first reading of the table and t_run that since the run began",
    source: "linear wear: Archard, J. Appl. Phys. 24 (1953) 981; with a power of time: Rhee, Wear 16 (1970) 431; that ends: Queener, Smith and Mitchell, Wear 8 (1965) 391; seating: VDI 2230 (2015), section 5.4.2; relaxation: logarithmic creep, Phillips, Phil. Mag. 9 (1905) 513",
    tell_tale: "the residual grows over the whole table, or in each run, the more the lower the preload is",
    parameters: &[
        Parameter::size(
            "lost_share",
            Quantity::PerTime,
            "share w of the preload that is lost per unit of time",
        )
        .within(0.0, 1.0)
        .likely(0.0, 1e-3),
        Parameter::size(
            "slowing_lost_share",
            Quantity::Number,
            "share s of the preload that wear which slows down takes by the time T",
        )
        .within(0.0, 0.99)
        .likely(0.0, 0.5),
        Parameter::shape("slowing_time", Quantity::Time, 3600.0, "time T by which it has taken the share s")
            .within(1e-3, 1e9)
            .likely(10.0, 1e6)
            .log(),
        Parameter::shape("slowing_exponent", Quantity::Number, 0.5, "exponent p by which it slows down")
            .within(0.01, 1.0)
            .likely(0.2, 0.8),
        Parameter::size(
            "seated_lost_share",
            Quantity::Number,
            "share b of the preload that is lost until the joints have seated",
        )
        .within(0.0, 0.99)
        .likely(0.0, 0.5),
        Parameter::shape("seating_time", Quantity::Time, 600.0, "time constant tau of seating")
            .within(1e-3, 1e9)
            .likely(10.0, 1e5)
            .log(),
        Parameter::size(
            "relaxing_lost_share",
            Quantity::Number,
            "share r of the preload that relaxes after each setting, each time its age grows e-fold",
        )
        .within(0.0, 0.5)
        .likely(0.0, 0.1),
        Parameter::shape(
            "relaxing_time",
            Quantity::Time,
            30.0,
            "time tau_r from which on it relaxes with the logarithm",
        )
        .within(1e-3, 1e9)
        .likely(1.0, 1e4)
        .log(),
    ],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], row: &Row, load: &mut Load) {
    let mut left = own[0] * -row.time_s + 1.0;
    if row.time_s > 0.0 {
        let grown = Dual::constant(row.time_s).quotient(&own[2]).power(&own[3]);
        left.add_product(-1.0, &own[1], &grown);
    }
    left.add_product(-1.0, &own[4], &own[5].settled(row.time_s));
    left.add_product(-1.0, &own[6], &(own[7].recip() * row.run_time_s).ln_1p());
    load.preload_N *= left;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    /// Share of the preload that is left with some of the numbers other than neutral.
    fn left(numbers: &[(usize, f64)]) -> f64 {
        let mut own: Vec<f64> = SPEC.parameters.iter().map(|parameter| parameter.neutral).collect();
        for (place, value) in numbers {
            own[*place] = *value;
        }
        load(&SPEC, &own).preload_N.value / ROW.preload_N
    }

    /// A share of 1e-4 a second is 5 % after 500 s.
    #[test]
    fn it_takes_preload_with_time() {
        assert_close(left(&[(0, 1e-4)]), 0.95);
    }

    /// 20 % by 2000 s is half of that after a quarter of the time.
    #[test]
    fn it_slows_down() {
        assert_close(left(&[(1, 0.2), (2, 2000.0), (3, 0.5)]), 0.9);
    }

    /// After ten time constants the joints hold.
    #[test]
    fn it_ends_where_joints_have_seated() {
        assert!((left(&[(4, 0.2), (5, 50.0)]) - 0.8).abs() < 1e-4);
    }

    /// A minute after the run began, with 60/(e - 1) s: one e-fold.
    #[test]
    fn it_relaxes_after_each_setting() {
        assert_close(left(&[(6, 0.05), (7, 60.0 / 1f64.exp_m1())]), 0.95);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
