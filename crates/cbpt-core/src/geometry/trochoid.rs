//! The deceleration pair's tracks: epicycloid and hypocycloid groove centrelines at a ball.
//!
//! Ball i stands at phi from the ray O2 -> P about the centre O2 of the ball circle. Every in-plane normal passes
//! through the pitch point P, at Z2 e from O2 and at Zo e from the centre of the output plate. With
//! D = 1 + K^2 - 2 K cos(phi):
//! - signed arm about the centre of the output plate: a = Zo e sin(phi) / sqrt(D);
//! - direction from the ball to P: (K - cos(phi), -sin(phi)) / sqrt(D);
//! - signed in-plane curvature, above 0 with the centre of curvature on P's side:
//!   epicycloid [1 + Z2 K^2 - (1 + Z2) K cos(phi)] / (R D^1.5),
//!   hypocycloid [1 - Z2 K^2 + (Z2 - 1) K cos(phi)] / (R D^1.5).

use crate::drive::Deceleration;
use crate::real::Real;

/// Where a ball stands on the two tracks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallOnTracks<T = f64> {
    /// Signed arm of the contact normals about the centre of the output plate, m.
    pub arm_m: T,
    /// Unit vector from the ball to the pitch point: along and across the line of centres.
    pub to_pitch_point: [T; 2],
    /// Curvature of the epicycloid track, 1/m, above 0 with its centre on the pitch point's side.
    pub epicycloid_curvature_per_m: T,
    /// Curvature of the hypocycloid track, 1/m, with the same sign rule.
    pub hypocycloid_curvature_per_m: T,
}

impl BallOnTracks {
    /// The ball at `phi_rad` from the ray through the pitch point.
    pub fn at(pair: &Deceleration, phi_rad: f64) -> Self {
        let (k, r0) = (pair.short_amplitude_coefficient, pair.rolling_circle_radius_m);
        on_tracks(pair.ball_count, pair.output_lobes(), k, r0, phi_rad)
    }
}

/// The ball at `phi_rad`, from Z2, Zo, K and r0.
pub fn on_tracks<T: Real>(
    ball_count: u32,
    output_lobes: u32,
    short_amplitude_coefficient: T,
    rolling_circle_radius_m: T,
    phi_rad: T,
) -> BallOnTracks<T> {
    let z2 = f64::from(ball_count);
    let (k, r0) = (short_amplitude_coefficient, rolling_circle_radius_m);
    let (half_sin, half_cos) = (phi_rad * 0.5).sin_cos();
    let (sin, cos) = (half_sin * half_cos * 2.0, -(half_sin * half_sin * 2.0) + 1.0);
    // (1 - K)^2 + 2 K (1 - cos) keeps its digits where K is near 1 and phi near 0.
    let beyond = -k + 1.0;
    let d = beyond * beyond + k * 4.0 * half_sin * half_sin;
    // Divided once: these are made anew for every geometry.
    let per_root = T::of(1.0) / d.sqrt();
    let per_scale = per_root / (r0 * z2 * d);
    BallOnTracks {
        arm_m: k * r0 * f64::from(output_lobes) * sin * per_root,
        to_pitch_point: [(k - cos) * per_root, -sin * per_root],
        epicycloid_curvature_per_m: (k * z2 * k + 1.0 - k * (1.0 + z2) * cos) * per_scale,
        hypocycloid_curvature_per_m: (-(k * z2 * k) + 1.0 + k * (z2 - 1.0) * cos) * per_scale,
    }
}

/// Which of the two cycloid grooves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Groove {
    /// The epicycloid groove, R e^(it) - e e^(i `Z2` t).
    Epicycloid,
    /// The hypocycloid groove, R e^(it) + e e^(-i `Z2` t).
    Hypocycloid,
}

/// Angle t of the groove's equation where the groove stands at a polar angle about the centre of its plate, rad.
///
/// By bisection: the polar angle t - atan2(e sin(Z t), R -+ e cos(Z t)) rises with t, as K < 1.
pub fn groove_angle_rad(pair: &Deceleration, groove: Groove, polar_angle_rad: f64) -> f64 {
    let (radius, e) = (pair.pitch_radius_m(), pair.eccentricity_m());
    let (lobes, along) = match groove {
        Groove::Epicycloid => (f64::from(pair.epicycloid_lobes()), -e),
        Groove::Hypocycloid => (f64::from(pair.hypocycloid_lobes()), e),
    };
    let polar = |t: f64| t - (e * (lobes * t).sin()).atan2(radius + along * (lobes * t).cos());
    let widest = (e / radius).asin();
    let (mut low, mut high) = (polar_angle_rad - widest, polar_angle_rad + widest);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if polar(middle) < polar_angle_rad { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Drive;

    /// Against the equations of both grooves in their plates.
    #[test]
    fn polar_angles_lead_back_to_the_groove() {
        let pair = *Drive::paper_base_case().deceleration();
        let (radius, e, z2) = (pair.pitch_radius_m(), pair.eccentricity_m(), f64::from(pair.ball_count));
        for (groove, sign) in [(Groove::Epicycloid, -1.0), (Groove::Hypocycloid, 1.0)] {
            for t in [-3.1, -0.2, 0.0, 0.07, 0.5, 1.0, 2.9] {
                let t: f64 = t;
                let x = radius * t.cos() + sign * e * (z2 * t).cos();
                let y = radius * t.sin() - e * (z2 * t).sin();
                assert!((groove_angle_rad(&pair, groove, y.atan2(x)) - t).abs() < 1e-14, "{t}");
            }
        }
    }

    /// Limit K -> 0: both tracks become the ball circle, of curvature 1/R, with the centre on P's side at phi = 180.
    #[test]
    fn small_amplitude_gives_the_ball_circle() {
        let pair =
            Deceleration { short_amplitude_coefficient: 1e-9, ..*Drive::paper_base_case().deceleration() };
        let ball = BallOnTracks::at(&pair, 2.0);
        let expected = 1.0 / pair.pitch_radius_m();
        for found in [ball.epicycloid_curvature_per_m, ball.hypocycloid_curvature_per_m] {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
    }

    /// The curvature formulas against the tracks themselves, differentiated numerically in each plate's own frame:
    /// epicycloid (R cos t - e cos Z2 t, R sin t - e sin Z2 t), hypocycloid (R cos t + e cos Z2 t, R sin t - e sin Z2 t);
    /// the ball at t sees the pitch point at phi = (Z2 - 1) t and (Z2 + 1) t.
    #[test]
    fn curvature_is_that_of_the_track() {
        let pair = *Drive::paper_base_case().deceleration();
        let (radius, e, z2) = (pair.pitch_radius_m(), pair.eccentricity_m(), f64::from(pair.ball_count));
        for (sign, lobes) in [(-1.0, z2 - 1.0), (1.0, z2 + 1.0)] {
            let track = |t: f64| {
                [radius * t.cos() + sign * e * (z2 * t).cos(), radius * t.sin() - e * (z2 * t).sin()]
            };
            for t in [0.003, 0.01, 0.05, 0.1, 0.2] {
                let h = 2e-5;
                let (m, c, p) = (track(t - h), track(t), track(t + h));
                let first: Vec<f64> = (0..2).map(|i| (p[i] - m[i]) / (2.0 * h)).collect();
                let second: Vec<f64> = (0..2).map(|i| (p[i] - 2.0 * c[i] + m[i]) / (h * h)).collect();
                let cross = first[0] * second[1] - first[1] * second[0];
                let expected = cross / (first[0] * first[0] + first[1] * first[1]).powf(1.5);
                let ball = BallOnTracks::at(&pair, lobes * t);
                let found = if sign < 0.0 {
                    ball.epicycloid_curvature_per_m
                } else {
                    ball.hypocycloid_curvature_per_m
                };
                assert!((found - expected).abs() < 1e-4 * expected.abs().max(1.0), "{t}: {found} {expected}");
            }
        }
    }
}
