//! A file with other effects is the same file but for these.

use serde_json::json;

use super::{RING, read};

#[test]
fn new_effects_leave_the_rest_of_a_file_as_it_is() {
    let text = format!(
        "# mine\n{RING}\n[[effect]]\nid = \"preload_loss\" # as measured\nlost_share = 0.1 # a tenth\n\
         \n[[effect]]\nid = \"bearing_play\"\nclearance_um = 3 # um\n# end\n"
    );
    let case = read(&text);
    assert_eq!(case.to_toml_like(&text).unwrap(), text);
    let effects = [
        json!({"id": "bearing_play", "clearance_m": 4e-6}),
        json!({"id": "friction_hysteresis", "friction_radius_m": 5e-4}),
    ];
    let other = case.with_effects(&effects).unwrap();
    let written = other.to_toml_like(&text).unwrap();
    assert_eq!(read(&written), other, "{written}");
    assert!(written.starts_with(&format!("# mine\n{RING}")), "{written}");
    for part in ["clearance_um = 4.0 # um", "friction_radius_um = 500.0", "# end"] {
        assert!(written.contains(part), "{part} in\n{written}");
    }
    assert!(!written.contains("preload_loss"), "{written}");
}

#[test]
fn an_own_effect_keeps_its_unit_and_its_comment() {
    let text = format!(
        "{RING}\n[[effect]]\nid = \"mine\"\nport = \"series\"\nexpression = \"a * torque_Nm\"\n\
         parameters = {{ a = {{ unit = \"arcsec/(N m)\", start = 0.5 }} }} # first guess\n"
    );
    let case = read(&text);
    let start = 0.25 * case.effects[0].values()[0] / 0.5;
    let parameters = json!({"a": {"unit": "rad/(N m)", "start": start}});
    let now =
        json!({"id": "mine", "port": "series", "expression": "a * torque_Nm", "parameters": parameters});
    let written = case.with_effects(&[now]).unwrap().to_toml_like(&text).unwrap();
    assert!(written.contains("# first guess") && written.contains("start = "), "{written}");
    assert_eq!(read(&written).effects[0].values(), [start], "{written}");
}

#[test]
fn a_number_that_its_unit_does_not_have_is_written_as_the_nearest() {
    let text = format!("{RING}\n[[effect]]\nid = \"bearing_play\"\nclearance_um = 3 # um\n");
    let case = read(&text);
    let mut same = 0;
    // No number of micrometres reads as the first of these.
    let clearances = std::iter::once(2.085_935_658_166_481_9e-7)
        .chain((0..200).map(|step| 2e-7 * (1.0 + f64::from(step) / 997.0).powi(3)));
    for clearance_m in clearances {
        let now = case.with_effects(&[json!({"id": "bearing_play", "clearance_m": clearance_m})]).unwrap();
        let written = now.to_toml_like(&text).unwrap();
        assert!(written.contains("clearance_um = ") && written.contains("# um"), "{written}");
        let read = read(&written).effects[0].values()[0];
        assert!([clearance_m, clearance_m.next_up(), clearance_m.next_down()].contains(&read), "{written}");
        same += usize::from(read.to_bits() == clearance_m.to_bits());
    }
    assert!(same > 150, "{same} of 201 are the same to the last bit");
}
