//! The table: sizes, spellings, and the way there and back.
#![allow(clippy::unwrap_used, clippy::float_cmp)] // sizes are the same numbers, not near ones

use super::*;

fn unit(symbol: &str) -> &'static Unit {
    all().find(|unit| unit.symbol == symbol).unwrap()
}

#[test]
fn no_symbol_stands_twice_and_no_spelling_within_a_quantity() {
    let symbols: Vec<&str> = all().map(|unit| unit.symbol).collect();
    for (index, symbol) in symbols.iter().enumerate() {
        assert!(!symbols[..index].contains(symbol), "{symbol}");
    }
    for quantity in Quantity::ALL {
        let mut seen = Vec::new();
        for unit in quantity.units() {
            assert_eq!(unit.quantity, quantity, "{}", unit.symbol);
            for spelling in unit.spellings.iter().chain([&unit.symbol]) {
                assert!(!seen.contains(spelling), "{spelling}");
                seen.push(spelling);
            }
        }
    }
}

#[test]
fn the_first_unit_is_that_of_si() {
    for quantity in Quantity::ALL {
        let si = quantity.si();
        assert_eq!((si.size(), si.per_si(), si.to_si(1.5), si.of_si(1.5)), (1.0, 1.0, 1.5, 1.5));
        assert!(quantity.units().contains(quantity.usual()), "{quantity:?}");
    }
}

#[test]
fn sizes_are_those_of_the_si_brochure() {
    assert_eq!((unit("arcsec").size(), unit("deg").size()), (ARCSEC, DEGREE));
    assert_eq!(unit("arcsec").per_si(), ARCSEC_PER_RAD);
    for (symbol, size) in [
        ("mm", 1e-3),
        ("nm", 1e-9),
        ("deg", PI / 180.0),
        ("arcsec", PI / 648_000.0),
        ("kNm", 1e3),
        ("GPa", 1e9),
        ("h", 3600.0),
        ("per_h", 1.0 / 3600.0),
        ("N_per_um", 1e6),
        ("Nm_per_deg", 180.0 / PI),
        ("lbf", 4.448_221_615_260_5),
        ("lbf_in", 0.112_984_829_027_616_7),
        ("lbf_ft", 1.355_817_948_331_400_4),
    ] {
        assert_eq!(unit(symbol).size(), size, "{symbol}");
    }
    for (symbol, size) in [
        ("per_arcsec2", (648_000.0 / PI).powi(2)),
        ("arcsec_per_h", PI / 648_000.0 / 3600.0),
        ("per_mrad2", 1e6),
    ] {
        assert!((unit(symbol).size() / size - 1.0).abs() < 1e-15, "{symbol}");
    }
}

#[test]
fn one_length_in_three_units_is_one_number() {
    assert_eq!((unit("mm").to_si(1.2), unit("um").to_si(1200.0)), (0.0012, 0.0012));
}

#[test]
fn there_and_back_is_the_same_number() {
    for unit in all() {
        for value in [0.3, -7.25, 1234.5] {
            let si = unit.to_si(value);
            assert!((unit.of_si(si) / value - 1.0).abs() < 1e-12, "{}", unit.symbol);
            assert!((si - unit.offset - value * unit.size()).abs() <= 1e-12 * si.abs(), "{}", unit.symbol);
        }
    }
}

#[test]
fn a_conversion_between_units_of_a_quantity_is_a_ratio_of_whole_numbers() {
    let found = |from: &str, to: &str| unit(from).conversion(unit(to));
    let exact = |times, over, plus| Some(Conversion { times, over, plus });
    assert_eq!(found("deg", "arcsec"), exact(3600.0, 1.0, 0.0));
    assert_eq!(found("mNm", "Nm"), exact(1.0, 1000.0, 0.0));
    assert_eq!(found("rad", "arcsec"), exact(648_000.0 / PI, 1.0, 0.0));
    assert_eq!(found("K", "degC"), exact(1.0, 1.0, -273.15));
    assert_eq!(found("degC", "degC"), exact(1.0, 1.0, 0.0));
    assert_eq!(found("K", "Nm"), None);
}
