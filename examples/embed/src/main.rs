//! Solve, sweep, compare and fit by the core alone.
#![allow(non_snake_case)] // units keep their capitals: torque_Nm
use cbpt_core::fit::{Measured, compare, fit};
use cbpt_core::predict::{Columns, Predictor, Rows};
use cbpt_core::sweep::{Progress, solve_all};
use cbpt_core::{Drive, InvalidInput, Load};

fn main() -> Result<(), InvalidInput> {
    let drive = Drive::paper_base_case();
    println!("{:?} rad at 5 N m", drive.solve(&Load::new(5.0, 600.0, 0.0)?).elastic_angle_rad());

    let torque_Nm: Vec<f64> = (-10..=10).map(f64::from).collect();
    let loads: Result<Vec<_>, _> = torque_Nm.iter().map(|&t| Load::new(t, 600.0, 0.0)).collect();
    println!("{:?} loads swept", solve_all(&drive, &loads?, &Progress::default()).map(|rows| rows.len()));

    let [zeros, preload_N, u_rad] = [0.0, 600.0, 1e-6].map(|value| vec![value; torque_Nm.len()]);
    let columns = Columns { run: &vec![1; torque_Nm.len()], time_s: &zeros, torque_Nm: &torque_Nm,
        preload_N: Some(&preload_N), input_angle_rad: &zeros, temperature_K: None, cycle: None };
    let mut model = Predictor::new(drive, &["contact_stiffness"], Rows::new(columns)?)?;
    let angle_rad = model.predict(&[1.2], &[])?.angle_rad; // readings of contacts that are 20 % stiffer
    let measured = Measured { angle_rad: &angle_rad, u_rad: &u_rad };
    println!("as drawn: rmse {:.1e} rad", compare(&mut model, &[1.0], &measured)?.rmse_rad);
    let found = fit(&mut model, &[1.0], &[0], &measured)?;
    println!("fitted: stiffness times {:.3} +- {:.3}, rmse {:.1e} rad", found.values[0], found.u[0], found.misfit.rmse_rad);
    Ok(())
}
