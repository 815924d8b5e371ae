//! The spin of one ball that dissipates least.
//!
//! Coulomb friction at every contact is rigid and plastic: the ball takes the angular velocity w that minimises
//!
//! P(w)/mu = sum over contacts Q (|s| + kappa |psi|), s = u t + (w - Omega z) x r c, psi = (w - Omega z) . c,
//!
//! with Q the normal force, s the slip, psi the pivoting and kappa = (3/8) a E(m) of the contact ellipse. t is the track, n its normal in
//! the plane, z the axis (t x n = z). Every contact normal c lies in the plane of n and z, and every plate moves against the
//! ball along t. So a spin about t adds r `w_t` across the track to every slip and nothing to any pivoting: `w_t` = 0 at the
//! minimum, exactly. Slips are then along t, and with v = r (`w_n`, `w_z`)
//!
//! P/mu = sum Q |u - r Omega `e_z`.l + v . l| + (Q kappa/r) |(v - r Omega z) . c|, l = (`c_z`, -`c_n`):
//!
//! a sum of absolute values, two unknowns. Its minimum lies where two of the lines on which a term vanishes cross (a linear
//! programme has its optimum at a vertex), and a ball has at most eight lines, so all crossings are tried: no iteration, and
//! nothing to converge.
//!
//! The proof of a minimum is the dual: max -sum lambda b with |lambda| <= weight and sum lambda a = 0. At the crossing found the
//! terms that do not vanish have lambda = +- weight and sum up to a gradient g; -g must lie in the zonogon of those that
//! vanish, whose gauge gamma is the largest of |g . d|/sum weight |a . d| over the directions d along its lines. Everything divided by
//! max(gamma, 1) is feasible, which gives a lower bound of the minimum: [`Spin::gap`] is its relative distance.

/// A contact as the spin of its ball sees it. Speeds and turns per radian of the input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Outward normal of the ball: in the plane towards `n`, and along the axis.
    pub normal: [f64; 2],
    /// Speed of the ball's centre against the plate along the track, m.
    pub track_speed_m: f64,
    /// Turn of the plate about the axis.
    pub plate_turn: f64,
    /// Normal force Q, N.
    pub force_N: f64,
    /// kappa = (3/8) a E(m), m.
    pub pivoting_arm_m: f64,
}

impl Touch {
    /// Slip along the track, m, and pivoting, of a ball of radius r (m) with the spin (`w_n`, `w_z`).
    pub fn motion(&self, ball_radius_m: f64, spin: [f64; 2]) -> [f64; 2] {
        let ([cn, cz], turn) = (self.normal, spin[1] - self.plate_turn);
        let slip_m = self.track_speed_m + ball_radius_m * (spin[0] * cz - turn * cn);
        [slip_m, spin[0] * cn + turn * cz]
    }

    /// Friction power over mu under a motion, N m for each radian of the input.
    pub fn loss_Nm(&self, [slip_m, pivoting]: [f64; 2]) -> f64 {
        self.force_N * (slip_m.abs() + self.pivoting_arm_m * pivoting.abs())
    }
}

/// The spin found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spin {
    /// About the normal of the track in the plane, and about the axis; 0 about the track. Per radian of the input.
    pub spin: [f64; 2],
    /// Friction power over mu, N m for each radian of the input.
    pub loss_Nm: f64,
    /// Relative distance to a proved lower bound of the least power; rounding alone if the minimum is reached.
    pub gap: f64,
}

/// Most contacts of a ball.
pub const MOST_TOUCHES: usize = 4;
const MOST_LINES: usize = 2 * MOST_TOUCHES;

/// A term weight |a . v + b| with |a| = 1.
#[derive(Debug, Clone, Copy, Default)]
struct Line {
    a: [f64; 2],
    b: f64,
    weight: f64,
}

impl Line {
    fn at(&self, v: [f64; 2]) -> f64 {
        dot(self.a, v) + self.b
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// A crossing of lines that enclose less than this is none.
const PARALLEL: f64 = 1e-9;
/// A term that is smaller than this share of its parts vanishes.
const VANISHES: f64 = 1e-12;

/// The spin of a ball of radius r (m) with these contacts, four at most, that dissipates least. No loaded contact: no spin.
pub fn least_dissipation(ball_radius_m: f64, touches: &[Touch]) -> Spin {
    let mut store = [Line::default(); MOST_LINES];
    let mut count = 0;
    for touch in touches.iter().filter(|touch| touch.force_N > 0.0).take(MOST_TOUCHES) {
        let [cn, cz] = touch.normal;
        let rim = ball_radius_m * touch.plate_turn;
        let pivoting_weight = touch.force_N * touch.pivoting_arm_m / ball_radius_m;
        store[count] = Line { a: [cz, -cn], b: touch.track_speed_m + rim * cn, weight: touch.force_N };
        store[count + 1] = Line { a: [cn, cz], b: -rim * cz, weight: pivoting_weight };
        count += 2;
    }
    let lines = &store[..count];
    let v = best_crossing(lines);
    let [loss_Nm, bound_Nm] = loss_and_bound(lines, v);
    let gap = if loss_Nm > 0.0 { 1.0 - bound_Nm / loss_Nm } else { 0.0 };
    Spin { spin: v.map(|v| v / ball_radius_m), loss_Nm, gap }
}

fn best_crossing(lines: &[Line]) -> [f64; 2] {
    let mut best = ([0.0; 2], f64::INFINITY);
    for (i, first) in lines.iter().enumerate() {
        for second in &lines[i + 1..] {
            let sine = first.a[0] * second.a[1] - first.a[1] * second.a[0];
            if sine.abs() < PARALLEL {
                continue;
            }
            let v = [
                (first.a[1] * second.b - second.a[1] * first.b) / sine,
                (second.a[0] * first.b - first.a[0] * second.b) / sine,
            ];
            let value: f64 = lines.iter().map(|line| line.weight * line.at(v).abs()).sum();
            if value < best.1 {
                best = (v, value);
            }
        }
    }
    best.0
}

/// The sum at the crossing v, where terms that vanish are 0, and its proved lower bound.
fn loss_and_bound(lines: &[Line], v: [f64; 2]) -> [f64; 2] {
    let vanishes = |line: &Line| {
        line.at(v).abs() <= VANISHES * (dot(line.a.map(f64::abs), v.map(f64::abs)) + line.b.abs())
    };
    let (mut gradient, mut moving, mut still) = ([0.0; 2], 0.0, 0.0);
    for line in lines {
        let term = line.weight * line.at(v).abs();
        if vanishes(line) {
            still += term;
        } else {
            moving += term;
            let push = line.weight * line.at(v).signum();
            gradient = [gradient[0] + push * line.a[0], gradient[1] + push * line.a[1]];
        }
    }
    // Where no term vanishes nothing holds a gradient.
    let held_at_all = lines.iter().any(vanishes);
    let mut gauge: f64 = if held_at_all { 1.0 } else { f64::INFINITY };
    for line in lines.iter().filter(|line| vanishes(line)) {
        let along = [-line.a[1], line.a[0]];
        let held: f64 = lines
            .iter()
            .filter(|other| vanishes(other))
            .map(|other| other.weight * dot(other.a, along).abs())
            .sum();
        gauge = gauge.max(dot(gradient, along).abs() / held);
    }
    [moving, (moving - still) / gauge]
}
