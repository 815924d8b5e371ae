//! A model against measured angles, and its numbers fitted to them by least squares.
//!
//! - [`compare`]: how far a [`Predictor`] is off at given values;
//! - [`fit`]: the values of some of its numbers that bring it nearest, with their standard uncertainties.
//!
//! One zero of the angle is fitted to all readings. With residuals r_i = y_i - zero - model_i and the uncertainties u_i, the
//! misfit is chi^2 = sum (r_i/u_i)^2. Gauss-Newton with exact derivatives, damped after Levenberg and Marquardt, within the
//! limits of the numbers; uncertainties are those of the linear problem at the minimum (Bevington and Robinson, Data Reduction
//! and Error Analysis, 2003, chapter 8). Correlated noise and priors are in [`crate::posterior`], the weighing of effects
//! against each other is in the Python package.

use nalgebra::{DMatrix, DVector};

use crate::effect::Scale;
use crate::error::{InvalidInput, require};
use crate::predict::Predictor;

/// What was measured at each row of a predictor.
#[derive(Debug, Clone, Copy)]
pub struct Measured<'a> {
    /// Elastic angle, rad.
    pub angle_rad: &'a [f64],
    /// Standard uncertainty of each (k = 1), rad.
    pub u_rad: &'a [f64],
}

/// How far a model is off.
#[derive(Debug, Clone, PartialEq)]
pub struct Misfit {
    /// The zero of the angle that fits best, rad.
    pub zero_rad: f64,
    /// Reading minus zero minus model, rad; NaN where the model has no solution.
    pub residual_rad: Vec<f64>,
    /// Root mean square of the residuals, rad.
    pub rmse_rad: f64,
    /// Sum of the squared residuals in units of their uncertainty.
    pub chi2: f64,
    /// `chi2` by degrees of freedom: near 1 where model and uncertainties are right.
    pub chi2_per_dof: f64,
    /// Rows at which the model has no solution; they do not count.
    pub without_solution: usize,
}

/// Numbers fitted to readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// All values of the predictor, the free ones fitted, SI.
    pub values: Vec<f64>,
    /// Standard uncertainty of each free number, in the order asked for, SI; NaN where the readings do not determine it.
    pub u: Vec<f64>,
    /// The misfit there.
    pub misfit: Misfit,
    /// Steps taken.
    pub steps: usize,
    /// Whether no step gains any more.
    pub converged: bool,
}

const MOST_STEPS: usize = 200;
/// Relative gain in chi^2 that ends the search.
const ENOUGH: f64 = 1e-12;
const FIRST_DAMPING: f64 = 1e-3;
/// The damping at which no step is left.
const MOST_DAMPING: f64 = 1e12;

/// Holds the predictor at `values` (SI, in the order of [`Predictor::parameters`]) against measured angles.
///
/// # Errors
/// [`InvalidInput`] for lists of the wrong length, an uncertainty that is not above 0, and values that cannot be.
pub fn compare(
    predictor: &mut Predictor,
    values: &[f64],
    measured: &Measured<'_>,
) -> Result<Misfit, InvalidInput> {
    check(predictor, measured)?;
    let model = predictor.predict(values, &[])?.angle_rad;
    Ok(misfit(&model, measured, 1))
}

/// Fits the numbers at the places `free` (of [`Predictor::parameters`]) from `start`; the others keep their values there.
///
/// # Errors
/// As [`compare`], and for a start without any solution.
pub fn fit(
    predictor: &mut Predictor,
    start: &[f64],
    free: &[usize],
    measured: &Measured<'_>,
) -> Result<Fitted, InvalidInput> {
    check(predictor, measured)?;
    let coordinates: Vec<Coordinate> = free.iter().map(|&place| Coordinate::of(predictor, place)).collect();
    let mut values = start.to_vec();
    let mut system = System::at(predictor, &values, &coordinates, measured)?;
    require(
        system.rows > free.len(),
        "measured",
        system.rows,
        "must have more solved rows than free numbers",
    )?;
    let (mut damping, mut steps) = (FIRST_DAMPING, 0);
    let mut converged = free.is_empty();
    while !converged && steps < MOST_STEPS && damping < MOST_DAMPING {
        let mut tried = values.clone();
        for (coordinate, step) in coordinates.iter().zip(system.step(damping).iter()) {
            coordinate.moves(&mut tried, *step);
        }
        let next = System::at(predictor, &tried, &coordinates, measured)?;
        // A row that loses its solution would take its misfit along.
        if next.rows < system.rows || next.chi2.partial_cmp(&system.chi2) != Some(std::cmp::Ordering::Less) {
            converged =
                tried == values || next.chi2 - system.chi2 < ENOUGH * system.chi2 && next.rows == system.rows;
            damping *= 10.0;
            continue;
        }
        converged = system.chi2 - next.chi2 <= ENOUGH * system.chi2;
        (values, system) = (tried, next);
        damping = (damping / 10.0).max(1e-12);
        steps += 1;
    }
    let model = predictor.predict(&values, &[])?.angle_rad;
    let misfit = misfit(&model, measured, 1 + free.len());
    let u = coordinates.iter().zip(system.uncertainties()).map(|(c, u)| u * c.size(&values)).collect();
    Ok(Fitted { values, u, misfit, steps, converged })
}

/// How a free number is searched: by itself, or in its logarithm where it is a shape that may differ by powers of ten.
struct Coordinate {
    place: usize,
    logarithmic: bool,
    limits: (f64, f64),
}

/// The longest step in a logarithm.
const LONGEST: f64 = 1.0;

impl Coordinate {
    fn of(predictor: &Predictor, place: usize) -> Self {
        let number = &predictor.parameters()[place].parameter;
        let limits = number.limits();
        let logarithmic = number.scale() == Scale::Log && !number.is_size() && limits.0 > 0.0;
        Self { place, logarithmic, limits }
    }

    /// What one unit of the coordinate is at these values, SI.
    fn size(&self, values: &[f64]) -> f64 {
        if self.logarithmic { values[self.place] } else { 1.0 }
    }

    fn moves(&self, values: &mut [f64], step: f64) {
        let value = &mut values[self.place];
        let goal =
            if self.logarithmic { *value * step.clamp(-LONGEST, LONGEST).exp() } else { *value + step };
        *value = goal.clamp(self.limits.0, self.limits.1);
    }
}

fn check(predictor: &Predictor, measured: &Measured<'_>) -> Result<(), InvalidInput> {
    let rows = predictor.rows().len();
    let lengths = [("angle_rad", measured.angle_rad.len()), ("u_rad", measured.u_rad.len())];
    for (name, length) in lengths {
        require(length == rows, name, length, "must have one value for each row of the predictor")?;
    }
    for (row, u) in measured.u_rad.iter().enumerate() {
        require(
            u.is_finite() && *u > 0.0,
            format_args!("u_rad[{row}]"),
            u,
            "must be a finite number above 0",
        )?;
    }
    for (row, angle) in measured.angle_rad.iter().enumerate() {
        require(angle.is_finite(), format_args!("angle_rad[{row}]"), angle, "must be a finite number")?;
    }
    Ok(())
}

/// The misfit after the best zero, with so many numbers fitted.
fn misfit(model_rad: &[f64], measured: &Measured<'_>, fitted: usize) -> Misfit {
    let raw: Vec<f64> =
        measured.angle_rad.iter().zip(model_rad).map(|(angle, model)| angle - model).collect();
    let solved = || raw.iter().zip(measured.u_rad).filter(|(r, _)| r.is_finite());
    let weight: f64 = solved().map(|(_, u)| u.powi(-2)).sum();
    let zero_rad = solved().map(|(r, u)| r / (u * u)).sum::<f64>() / weight;
    let count = solved().count();
    let residual_rad: Vec<f64> = raw.iter().map(|r| r - zero_rad).collect();
    let kept = || residual_rad.iter().zip(measured.u_rad).filter(|(r, _)| r.is_finite());
    let chi2 = kept().map(|(r, u)| (r / u).powi(2)).sum::<f64>();
    let square = kept().map(|(r, _)| r * r).sum::<f64>();
    Misfit {
        zero_rad,
        rmse_rad: (square / count as f64).sqrt(),
        chi2,
        chi2_per_dof: chi2 / count.saturating_sub(fitted) as f64,
        without_solution: raw.len() - count,
        residual_rad,
    }
}

/// The linear problem at some values: columns of the free numbers with the zero taken out.
struct System {
    gram: DMatrix<f64>,
    push: DVector<f64>,
    chi2: f64,
    rows: usize,
}

impl System {
    fn at(
        predictor: &mut Predictor,
        values: &[f64],
        coordinates: &[Coordinate],
        measured: &Measured<'_>,
    ) -> Result<Self, InvalidInput> {
        let free: Vec<usize> = coordinates.iter().map(|coordinate| coordinate.place).collect();
        let mut found = predictor.predict(values, &free)?;
        let p = free.len();
        for slopes in found.sensitivities.chunks_mut(p.max(1)) {
            for (slope, coordinate) in slopes.iter_mut().zip(coordinates) {
                *slope *= coordinate.size(values);
            }
        }
        let slopes = |row: usize| &found.sensitivities[row * p..(row + 1) * p];
        let solved: Vec<usize> = (0..found.angle_rad.len())
            .filter(|&row| {
                found.angle_rad[row].is_finite() && slopes(row).iter().all(|slope| slope.is_finite())
            })
            .collect();
        // The zero is a further column; what it takes of the others and of the residual is taken out.
        let weight: f64 = solved.iter().map(|&row| measured.u_rad[row].powi(-2)).sum();
        let mean = |of: &dyn Fn(usize) -> f64| {
            solved.iter().map(|&row| of(row) / measured.u_rad[row].powi(2)).sum::<f64>() / weight
        };
        let residual = |row: usize| measured.angle_rad[row] - found.angle_rad[row];
        let zero = mean(&residual);
        let centre: Vec<f64> = (0..p).map(|k| mean(&|row| slopes(row)[k])).collect();
        let columns = DMatrix::from_fn(solved.len(), p, |i, k| {
            (slopes(solved[i])[k] - centre[k]) / measured.u_rad[solved[i]]
        });
        let r =
            DVector::from_fn(solved.len(), |i, _| (residual(solved[i]) - zero) / measured.u_rad[solved[i]]);
        Ok(Self {
            gram: columns.tr_mul(&columns),
            push: columns.tr_mul(&r),
            chi2: r.norm_squared(),
            rows: solved.len(),
        })
    }

    /// The damped step, in SI; a number that nothing shows stays.
    fn step(&self, damping: f64) -> DVector<f64> {
        let scale = self.scale();
        let mut scaled = self.scaled(&scale);
        for k in 0..scale.len() {
            scaled[(k, k)] += damping;
        }
        let push = self.push.component_div(&scale);
        scaled
            .cholesky()
            .map_or_else(|| DVector::zeros(scale.len()), |factor| factor.solve(&push).component_div(&scale))
    }

    /// Standard uncertainties of the free numbers.
    fn uncertainties(&self) -> Vec<f64> {
        let scale = self.scale();
        match self.scaled(&scale).cholesky() {
            Some(factor) => {
                let inverse = factor.inverse();
                (0..scale.len()).map(|k| inverse[(k, k)].sqrt() / scale[k]).collect()
            }
            None => vec![f64::NAN; scale.len()],
        }
    }

    /// Lengths of the columns, 1 for one of zeros: numbers may differ by many powers of ten.
    fn scale(&self) -> DVector<f64> {
        self.gram.diagonal().map(|square| if square > 0.0 { square.sqrt() } else { 1.0 })
    }

    fn scaled(&self, scale: &DVector<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(scale.len(), scale.len(), |i, k| self.gram[(i, k)] / (scale[i] * scale[k]))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // a test that cannot be set up has to stop
mod tests {
    use super::*;
    use crate::drive::Drive;
    use crate::predict::{Columns, Rows};

    const TORQUE_NM: [f64; 9] = [0.0, 2.0, 4.0, 6.0, 8.0, 4.0, 0.0, -4.0, -8.0];

    fn predictor(effects: &[&str]) -> Predictor {
        let n = TORQUE_NM.len();
        let rows = Rows::new(Columns {
            run: &vec![1; n],
            time_s: &(0..n).map(|row| row as f64).collect::<Vec<_>>(),
            torque_Nm: &TORQUE_NM,
            preload_N: Some(&vec![600.0; n]),
            input_angle_rad: &vec![0.0; n],
            temperature_K: None,
            cycle: None,
        });
        Predictor::new(Drive::paper_base_case(), effects, rows.unwrap()).unwrap()
    }

    /// Readings of the model itself at other values, with another zero.
    fn readings(predictor: &mut Predictor, values: &[f64], zero: f64) -> Vec<f64> {
        predictor.predict(values, &[]).unwrap().angle_rad.iter().map(|angle| angle + zero).collect()
    }

    #[test]
    fn a_model_is_not_off_its_own_readings() {
        let mut model = predictor(&["contact_stiffness"]);
        let angle = readings(&mut model, &[1.0], 3e-6);
        let u = vec![1e-7; angle.len()];
        let found = compare(&mut model, &[1.0], &Measured { angle_rad: &angle, u_rad: &u }).unwrap();
        assert!((found.zero_rad - 3e-6).abs() < 1e-15 && found.rmse_rad < 1e-15);
        let off = compare(&mut model, &[1.1], &Measured { angle_rad: &angle, u_rad: &u }).unwrap();
        assert!(off.chi2_per_dof > 1.0 && off.rmse_rad > 1e-7);
    }

    #[test]
    fn the_numbers_behind_readings_are_found() {
        for (effects, start, truth) in [
            (vec!["contact_stiffness"], vec![1.0], vec![1.3]),
            (vec!["friction_hysteresis"], vec![1e-4, 5e-5, 0.0, 0.0, 1.0], vec![4e-4, 2.2e-5, 0.0, 0.0, 1.0]),
        ] {
            let mut model = predictor(&effects);
            let off = |k: &usize| f64::abs(truth[*k] - start[*k]) > 0.0;
            let free: Vec<usize> = (0..truth.len()).filter(off).collect();
            let angle = readings(&mut model, &truth, -2e-6);
            let u = vec![1e-7; angle.len()];
            let found = fit(&mut model, &start, &free, &Measured { angle_rad: &angle, u_rad: &u }).unwrap();
            assert!(found.converged, "{effects:?}: {found:?}");
            for (value, truth) in found.values.iter().zip(&truth) {
                assert!((value - truth).abs() <= 1e-6 * truth.abs(), "{effects:?}: {found:?}");
            }
            assert!(found.u.iter().all(|u| u.is_finite() && *u > 0.0));
        }
    }

    /// The uncertainty is that of the straight line through the derivative.
    #[test]
    fn the_uncertainty_is_that_of_the_linear_problem() {
        let mut model = predictor(&["contact_stiffness"]);
        let angle = readings(&mut model, &[1.0], 0.0);
        let u = vec![2e-7; angle.len()];
        let found = fit(&mut model, &[1.0], &[0], &Measured { angle_rad: &angle, u_rad: &u }).unwrap();
        let slopes = model.predict(&[1.0], &[0]).unwrap().sensitivities;
        let mean = slopes.iter().sum::<f64>() / slopes.len() as f64;
        let square: f64 = slopes.iter().map(|slope| (slope - mean).powi(2)).sum();
        assert!((found.u[0] / (2e-7 / square.sqrt()) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn bad_input_is_named() {
        let mut model = predictor(&["contact_stiffness"]);
        let angle = vec![0.0; TORQUE_NM.len()];
        let short = compare(&mut model, &[1.0], &Measured { angle_rad: &angle[1..], u_rad: &angle });
        assert_eq!(short.unwrap_err().field, "angle_rad");
        let none = compare(&mut model, &[1.0], &Measured { angle_rad: &angle, u_rad: &angle });
        assert_eq!(none.unwrap_err().field, "u_rad[0]");
    }
}
