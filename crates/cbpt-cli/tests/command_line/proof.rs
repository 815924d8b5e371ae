//! `solve --certify`: what it tells, in which unit, and of what.

use serde_json::Value;

use crate::{Desk, EXAMPLE, number};

fn bounds(document: &Value, key: &str) -> [f64; 2] {
    [0, 1].map(|bound| number(&document["enclosure"][key][bound]))
}

#[test]
fn the_proof_encloses_the_answer_in_every_unit() {
    let desk = Desk::new("certify");
    let plain = desk.json("solve case.toml --json", 0);
    assert_eq!(plain.get("enclosure"), None);
    for unit in ["arcsec", "rad", "deg", "mrad"] {
        let proved = desk.json(&format!("solve case.toml --certify --json --angle-unit {unit}"), 0);
        let mut sum = [0.0; 2];
        for part in ["elastic_angle", "alpha_deceleration", "alpha_equal_speed"] {
            let key = format!("{part}_{unit}");
            let ([lower, upper], value) = (bounds(&proved, &key), number(&proved[&key]));
            assert!(lower < value && value < upper, "{key}: {value} is not in {lower} to {upper}");
            assert!(upper - lower < 1e-13 * value, "{key}");
            if part != "elastic_angle" {
                sum = [sum[0] + lower, sum[1] + upper];
            }
        }
        let [lower, upper] = bounds(&proved, &format!("elastic_angle_{unit}"));
        assert!((lower / sum[0] - 1.0).abs() < 1e-14 && (upper / sum[1] - 1.0).abs() < 1e-14);
    }
    let text = desk.cbpt("solve case.toml --certify").out;
    assert!(text.contains("Proved: the equations have one solution and no other"), "{text}");
}

#[test]
fn without_a_solution_nothing_is_proved() {
    let desk = Desk::new("certify_beyond");
    let beyond = desk.json("solve case.toml --torque-Nm 500 --certify --json", 3);
    assert_eq!(beyond["enclosure"], Value::Null);
    assert!(!desk.cbpt("solve case.toml --torque-Nm 500 --certify").out.contains("roved"));
}

#[test]
fn with_effects_the_meshing_points_are_proved_as_the_effects_make_them() {
    let desk = Desk::new("certify_effects");
    let plain = desk.json("solve case.toml --json", 0);
    let effects = [
        ("stiff", "id = \"contact_stiffness\"\nstiffness_scale = 1.1"),
        ("torsion", "id = \"output_torsion\"\ncompliance_arcsec_per_Nm = 0.4"),
    ];
    for (name, effect) in effects {
        desk.write(&format!("{name}.toml"), &format!("{EXAMPLE}\n[[effect]]\n{effect}\n"));
    }
    let angle = |file: &str| {
        let proved = desk.json(&format!("solve {file}.toml --certify --json"), 0);
        (bounds(&proved, "elastic_angle_arcsec"), number(&proved["elastic_angle_arcsec"]))
    };
    let unchanged = number(&plain["elastic_angle_arcsec"]);
    let ([lower, upper], shown) = angle("stiff");
    assert!(lower < shown && shown < upper && upper < 0.99 * unchanged);
    // A shaft behind the meshing points adds to what is shown and leaves them as they are.
    let ([lower, upper], shown) = angle("torsion");
    assert!(lower < unchanged && unchanged < upper && shown > upper);
    let text = desk.cbpt("solve torsion.toml --certify").out;
    assert!(text.contains("the elastic angle of the meshing points lies"), "{text}");
}

#[test]
fn a_torsion_spring_is_refused() {
    let desk = Desk::new("certify_spring");
    desk.write("spring.toml", "[torsion_spring]\ntorsional_stiffness_Nm_per_rad = 1e4\n");
    desk.cbpt("solve spring.toml --torque-Nm 1 --certify")
        .refused(&["a proof is about the balls and grooves"]);
}
