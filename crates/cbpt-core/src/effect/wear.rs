//! Preload lost with time.
//!
//! N_Z -> N_Z (1 - w t - s (t/T)^p - b (1 - exp(-t/tau))), t since the table's first reading. Steady wear takes a share of the preload in
//! proportion to time; the wear of surfaces that run in slows down (p < 1), as they come to bear on more of their asperities; joints
//! that seat under their screws lose it and then hold.

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
    equation: "N_Z -> N_Z (1 - w t - s (t/T)^p - b (1 - exp(-t/tau))), where t is the time since the first reading of the table",
    source: "linear wear: Archard, J. Appl. Phys. 24 (1953) 981; wear that slows down: Queener, Smith and Mitchell, Wear 8 (1965) 391; seating: VDI 2230 (2015), section 5.4.2",
    tell_tale: "the residual grows slowly over the whole table",
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
    load.preload_N *= left;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    /// A share of 1e-4 a second is 5 % after 500 s.
    #[test]
    fn it_takes_preload_with_time() {
        assert_close(
            load(&SPEC, &[1e-4, 0.0, 3600.0, 0.5, 0.0, 600.0]).preload_N.value,
            0.95 * ROW.preload_N,
        );
    }

    /// 20 % by 2000 s is half of that after a quarter of the time.
    #[test]
    fn it_slows_down() {
        assert_close(load(&SPEC, &[0.0, 0.2, 2000.0, 0.5, 0.0, 600.0]).preload_N.value, 0.9 * ROW.preload_N);
    }

    /// After ten time constants the joints hold.
    #[test]
    fn it_ends_where_joints_have_seated() {
        let left = load(&SPEC, &[0.0, 0.0, 3600.0, 0.5, 0.2, 50.0]).preload_N.value;
        assert!((left / ROW.preload_N - 0.8).abs() < 1e-4);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
