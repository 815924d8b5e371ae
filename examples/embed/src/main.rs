//! Torsional stiffness over torque of the paper's base case, by the core alone.

#![allow(non_snake_case)] // units keep their capitals: torque_Nm

use cbpt_core::{Drive, InvalidInput, Load};

fn main() -> Result<(), InvalidInput> {
    let drive = Drive::paper_base_case();
    println!("torque_Nm  elastic_angle_urad  torsional_stiffness_Nm_per_mrad");
    for torque_Nm in [0.0, 5.0, 10.0, 15.0, 20.0, 25.0] {
        let solution = drive.solve(&Load::new(torque_Nm, 600.0, 0.0)?);
        match (solution.elastic_angle_rad(), solution.torsional_stiffness_Nm_per_rad) {
            (Some(angle), Some(stiffness)) => {
                println!("{torque_Nm:9.1}  {:18.4}  {:31.4}", angle * 1e6, stiffness * 1e-3);
            }
            _ => println!("{torque_Nm:9.1}  {}", solution.status),
        }
    }
    Ok(())
}
