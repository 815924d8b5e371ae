//! What helps who writes a file: the key that was meant, the line with a caret, one way to name a number.

use super::super::{Case, CaseError};
use super::{RING, edited, read};

fn refused(text: &str) -> CaseError {
    Case::from_toml(text, "c.toml").unwrap_err()
}

#[test]
fn what_people_write_for_a_key_is_told_with_the_size_that_they_mean() {
    for (written, meant) in [
        ("ball_diameter_mm = 3", "did you mean ball_radius_mm = 1.5?"),
        ("ball_diameter_um = 2401", "did you mean ball_radius_um = 1200.5?"),
        ("ball_dia_mm = 3", "did you mean ball_radius_mm = 1.5?"),
        ("ball_diameter = 3", "did you mean ball_radius_mm?"),
    ] {
        let error = refused(&edited("ball_radius_mm = 1.2\ngroove", &format!("{written}\ngroove")));
        assert_eq!(error.mistakes.len(), 1, "{error}");
        let words = error.mistakes[0].words();
        assert!(words.contains(meant) && words.contains("half of the diameter"), "{words}");
    }
    for balls in ["balls", "n_balls", "number_of_balls"] {
        let error = refused(&edited("ball_count = 20", &format!("{balls} = 20")));
        assert_eq!(error.mistakes.len(), 1, "{error}");
        assert_eq!(error.mistakes[0].nearest.as_deref(), Some("ball_count"));
    }
    let elsewhere = refused(&edited("ball_count = 20", "ball_count = 20\npitch_diameter_mm = 70"));
    assert!(elsewhere.to_string().contains("the key belongs to [equal_speed]"), "{elsewhere}");
}

#[test]
fn a_terminal_sees_the_line_with_a_caret_under_the_mistake() {
    for (line, under) in
        [("ball_count = twenty", "twenty"), ("  ball_count = \"ä\" # x", "\"ä\""), ("bll = 1", "bll")]
    {
        let error = refused(&edited("ball_count = 20", line));
        let shown = error.shown();
        let place = shown.lines().position(|shown| shown.ends_with(line)).unwrap();
        let [above, below] = [place, place + 1].map(|place| shown.lines().nth(place).unwrap());
        let of = |text: &str, part: &str| text.split(part).next().unwrap().chars().count();
        assert_eq!(of(below, "^"), of(above, under), "{shown}");
        assert!(!error.to_string().contains('^'));
    }
}

#[test]
fn a_line_of_a_file_does_not_steer_the_terminal_nor_fill_it() {
    let long = format!("ball_count = \"\x1b[2J{}\"", "x".repeat(500));
    let shown = refused(&edited("ball_count = 20", &long)).shown();
    let line = shown.lines().find(|line| line.contains(" | ")).unwrap();
    assert!(!line.contains('\x1b') && line.chars().count() < 110, "{line:?}");
}

#[test]
fn a_tolerance_may_be_named_as_an_axis_of_a_plan() {
    let flat = format!("{RING}\n[tolerance]\ndeceleration_ball_radius_um = 2\nload_preload_N = 40\n");
    let dotted = format!("{RING}\n[tolerance]\ndeceleration.ball_radius_um = 2\nload.preload_N = 40\n");
    assert_eq!(read(&flat), read(&dotted));
    assert!(
        refused(&format!("{flat}deceleration.ball_radius_um = 2\n")).to_string().contains("already given")
    );
}
