//! Hertz point contact: two relative curvatures and a contact modulus give stiffness, ellipse and pressure.
//!
//! Pure functions; `lanes` makes many contacts at once. The exact solution with complete elliptic integrals, for smooth bodies whose relative
//! curvatures c1 and c2 (sums of 1/radius in the two principal directions, both above 0) lie along common axes.
//! Source: K. L. Johnson, Contact Mechanics (1985), section 4.2.
//!
//! With the ratio kappa = a/b >= 1 of the semi-axes, m = 1 - 1/kappa^2 and the complete integrals K(m), E(m):
//! - larger over smaller curvature: (kappa^2 E - K) / (K - E);
//! - force over approach^1.5: k = (2 pi / 3) E* kappa sqrt(2 E / (c1 + c2)) / K^1.5;
//! - major semi-axis: a^3 = 3 N kappa^2 E / (pi E* (c1 + c2)); peak pressure p = 3 N / (2 pi a b).

// What runs in lanes must be inlined into the function that knows the instruction set.
#[allow(clippy::inline_always)]
pub(crate) mod lanes;

use std::f64::consts::PI;

/// One contact, ready to be loaded: nothing here depends on the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzContact {
    /// Approach over force^(2/3), m/N^(2/3): k^(-2/3).
    pub compliance: f64,
    /// Ratio of the semi-axes a/b, 1 or more.
    pub ellipticity: f64,
    /// Sum c1 + c2 of the relative curvatures, 1/m.
    pub curvature_sum_per_m: f64,
    /// Contact modulus E*, Pa.
    pub contact_modulus_Pa: f64,
}

/// What a force does to a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedContact {
    /// Approach of the two bodies, m.
    pub approach_m: f64,
    /// Semi-axis of the contact ellipse along the weaker curvature, m.
    pub major_semi_axis_m: f64,
    /// Semi-axis of the contact ellipse along the stronger curvature, m.
    pub minor_semi_axis_m: f64,
    /// Pressure in the middle of the ellipse, Pa.
    pub peak_pressure_Pa: f64,
}

impl HertzContact {
    /// Contact of two bodies with relative curvatures `curvature_1_per_m` and `curvature_2_per_m` (1/m, both above
    /// 0, order indifferent) and contact modulus E* (Pa). `None` where a curvature is not above 0 or not finite: such
    /// a contact is not an ellipse.
    pub fn new(curvature_1_per_m: f64, curvature_2_per_m: f64, contact_modulus_Pa: f64) -> Option<Self> {
        // Asked of each number by itself: the smaller of two would hide one that is not a number.
        let usable = |value: f64| value.is_finite() && value > 0.0;
        if ![curvature_1_per_m, curvature_2_per_m, contact_modulus_Pa].into_iter().all(usable) {
            return None;
        }
        let weak = curvature_1_per_m.min(curvature_2_per_m);
        let strong = curvature_1_per_m.max(curvature_2_per_m);
        let (ellipticity, k, e) = ellipticity(strong / weak);
        let sum = weak + strong;
        let stiffness =
            2.0 * PI / 3.0 * contact_modulus_Pa * ellipticity * (2.0 * e / sum).sqrt() / (k * k.sqrt());
        let compliance = stiffness.cbrt().powi(-2);
        Some(Self { compliance, ellipticity, curvature_sum_per_m: sum, contact_modulus_Pa })
    }

    /// Force over approach^1.5, N/m^1.5.
    pub fn stiffness(&self) -> f64 {
        stiffness_of(self.compliance)
    }

    /// Semi-axis of the contact ellipse along the weaker curvature for a force of 1 N, m; it grows with the cube root of
    /// the force.
    pub fn major_semi_axis_at_1N_m(&self) -> f64 {
        let complement = self.ellipticity.powi(-2);
        let e = Elliptic::new(-(-2.0 * self.ellipticity.ln()).exp_m1(), complement).e;
        (3.0 * e / (complement * PI * self.contact_modulus_Pa * self.curvature_sum_per_m)).cbrt()
    }

    /// (3/8) a E(m) for a force of 1 N, m: torque that resists pivoting over the friction force (Johnson 1985, section 8.5);
    /// it grows with the cube root of the force.
    pub fn pivoting_arm_at_1N_m(&self) -> f64 {
        let complement = self.ellipticity.powi(-2);
        let e = Elliptic::new(-(-2.0 * self.ellipticity.ln()).exp_m1(), complement).e;
        0.375 * e * self.major_semi_axis_at_1N_m()
    }

    /// d ln k / d ln c of one of the two curvatures that the contact was made of, `varied_per_m`, the other being
    /// `other_per_m`.
    ///
    /// With ln k = const + ln kappa + ln(E)/2 - 3/2 ln K - ln(c1 + c2)/2, all of them functions of ln kappa but the last,
    /// and ln kappa one of the ratio of the curvatures.
    pub fn stiffness_slope(&self, varied_per_m: f64, other_per_m: f64) -> f64 {
        let log_kappa = self.ellipticity.ln();
        let (_, ratio_per_log_kappa, ..) = curvature_mismatch(log_kappa, 0.0);
        let (m, complement) = (-(-2.0 * log_kappa).exp_m1(), (-2.0 * log_kappa).exp());
        let integrals = Elliptic::new(m, complement);
        // Both are one half at the circle, where they cannot be divided.
        let (log_k, log_e) = if m > 0.0 {
            (
                integrals.e_minus_complement_k / (m * integrals.k),
                -complement * integrals.k_minus_e / (m * integrals.e),
            )
        } else {
            (0.5, -0.5)
        };
        let by_ratio = (1.0 + 0.5 * log_e - 1.5 * log_k) / ratio_per_log_kappa;
        let sign = if varied_per_m >= other_per_m { 1.0 } else { -1.0 };
        sign * by_ratio - 0.5 * varied_per_m / (varied_per_m + other_per_m)
    }

    /// Approach, ellipse and pressure under a normal force (N, 0 or more).
    pub fn under(&self, force_N: f64) -> LoadedContact {
        let major = self.major_semi_axis_at_1N_m() * force_N.cbrt();
        let minor = major / self.ellipticity;
        LoadedContact {
            approach_m: self.compliance * force_N.cbrt().powi(2),
            major_semi_axis_m: major,
            minor_semi_axis_m: minor,
            peak_pressure_Pa: if force_N > 0.0 { 1.5 * force_N / (PI * major * minor) } else { 0.0 },
        }
    }
}

/// Stiffness of contacts in series (N/m^1.5): k = (k_a^(-2/3) + k_b^(-2/3))^(-3/2), 0 if either is missing.
///
/// Both carry the same force and their approaches add.
pub fn in_series(contacts: [Option<HertzContact>; 2]) -> f64 {
    let [Some(a), Some(b)] = contacts else { return 0.0 };
    stiffness_of(a.compliance + b.compliance)
}

/// k from k^(-2/3).
fn stiffness_of(compliance: f64) -> f64 {
    1.0 / (compliance * compliance.sqrt())
}

/// Ratio of the semi-axes and the two integrals for a ratio of curvatures `ratio` >= 1.
///
/// Newton on log(kappa): the logarithm of the curvature ratio is nearly linear in it, so a few steps reach rounding.
fn ellipticity(ratio: f64) -> (f64, f64, f64) {
    let target = ratio.ln();
    // Exact in the limit of a circle; within a few per cent elsewhere (Brewe and Hamrock 1977).
    let mut log_kappa = 2.0 / PI * target;
    let mut integrals = (PI / 2.0, PI / 2.0);
    for _ in 0..30 {
        let (mismatch, slope, k, e) = curvature_mismatch(log_kappa, target);
        integrals = (k, e);
        let step = mismatch / slope;
        if step.abs() < 4.0 * f64::EPSILON * log_kappa.max(1.0) {
            break;
        }
        log_kappa = (log_kappa - step).max(0.0);
    }
    (log_kappa.exp(), integrals.0, integrals.1)
}

/// log(curvature ratio) minus its target, and its derivative with log(kappa), at kappa = exp(log_kappa).
fn curvature_mismatch(log_kappa: f64, target: f64) -> (f64, f64, f64, f64) {
    // m = 1 - 1/kappa^2 and its complement, each without cancellation.
    let m = -(-2.0 * log_kappa).exp_m1();
    let complement = (-2.0 * log_kappa).exp();
    let integrals = Elliptic::new(m, complement);
    let (k, e) = (integrals.k, integrals.e);
    if m < 1e-3 {
        // K - E and kappa^2 E - K cancel near the circle; their series in m do not:
        // with D = (K - E)/m and B = (E - (1-m) K)/m, ratio = (E - (1-m)K)/((1-m)(K-E)) = B/((1-m) D).
        let series = |c: [f64; 4]| 1.0 + m * (c[0] + m * (c[1] + m * (c[2] + m * c[3])));
        let b = series([1.0 / 8.0, 3.0 / 64.0, 25.0 / 1024.0, 245.0 / 16384.0]);
        let d = series([3.0 / 8.0, 15.0 / 64.0, 175.0 / 1024.0, 2205.0 / 16384.0]);
        let mismatch = (b / d).ln() + 2.0 * log_kappa - target;
        // d/dm of ln B - ln D is -1/4 at m = 0; dm/dlog_kappa = 2 (1 - m).
        return (mismatch, 2.0 - 0.5 * complement, k, e);
    }
    let b = integrals.e_minus_complement_k;
    let d = integrals.k_minus_e;
    let mismatch = (b / d).ln() + 2.0 * log_kappa - target;
    // dK/dm = (E - (1-m)K) / (2 m (1-m)), dE/dm = (E - K)/(2 m), so
    // dB/dm = K/2 for B = E - (1-m) K, and dD/dm = E/(2 (1-m)) for D = K - E.
    let slope = 2.0 + complement * k / b - e / d;
    (mismatch, slope, k, e)
}

/// Complete elliptic integrals of parameter m in [0, 1), by the arithmetic-geometric mean.
struct Elliptic {
    k: f64,
    e: f64,
    k_minus_e: f64,
    e_minus_complement_k: f64,
}

impl Elliptic {
    /// A & S 17.6: K = pi / (2 AGM(1, sqrt(1-m))), (K - E)/K = sum 2^(n-1) c_n^2, where c_0^2 = m.
    /// `complement` is 1 - m, given because it cannot be rebuilt from m near 1.
    fn new(m: f64, complement: f64) -> Self {
        let (mut a, mut g) = (1.0, complement.sqrt());
        let mut sum_beyond_first = 0.0;
        let mut weight = 1.0;
        for _ in 0..40 {
            let c = 0.5 * (a - g);
            (a, g) = (0.5 * (a + g), (a * g).sqrt());
            sum_beyond_first += weight * c * c;
            weight *= 2.0;
            if c.abs() < 1e-17 * a || c * c * weight < 1e-18 * m {
                break;
            }
        }
        let k = PI / (2.0 * a);
        let missing = 0.5 * m + sum_beyond_first;
        Self {
            k,
            e: k * (1.0 - missing),
            k_minus_e: k * missing,
            // E - (1-m) K = K (m - missing) = K (m/2 - rest), free of cancellation for moderate m.
            e_minus_complement_k: k * (0.5 * m - sum_beyond_first),
        }
    }
}
