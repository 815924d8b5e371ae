//! Rows as the lines of a CSV file: the axes in their units, then what was found, numbers to their last digit.

use std::io::Write;
use std::ops::Range;

use cbpt_core::findings::UNBUILDABLE;
use cbpt_core::sweep::Progress;
use rayon::prelude::*;

use super::rows::{Rows, STATUSES};
use super::tally::Tally;
use super::{Plan, Values};
use cbpt_core::units::ARCSEC_PER_RAD;

/// What is found of each row, after its axes and before further columns of the plan, why its drive cannot be built (`finding`, where drives vary) and how
/// it ended (`status`). Only a ball drive has parts and a preload to hold.
const FOUND: [(&str, bool); 5] = [
    ("elastic_angle_arcsec", false),
    ("alpha_deceleration_arcsec", true),
    ("alpha_equal_speed_arcsec", true),
    ("residual", true),
    ("hold_preload_N", true),
];

impl Plan {
    /// The line of column names.
    pub fn csv_header(&self) -> Vec<u8> {
        let axes = self.axes().iter().map(|axis| axis.parameter.name.as_str());
        let found = FOUND.iter().filter(|(_, pairs)| !pairs || self.has_pairs()).map(|(name, _)| *name);
        let costs = self.columns().iter().map(|cost| cost.name());
        let words = self.has_findings().then_some("finding").into_iter().chain(["status"]);
        let mut writer = csv::Writer::from_writer(Vec::new());
        // Into memory, which takes everything.
        let _ = writer.write_record(axes.chain(found).chain(costs).chain(words));
        writer.into_inner().unwrap_or_default()
    }

    /// The lines of these rows, and how they ended; `None` if it was cancelled. Runs on the threads of the pool it is called
    /// in.
    pub fn csv(&self, rows: &Range<u64>, progress: &Progress) -> Option<(Vec<u8>, Tally)> {
        let blocks: Option<Vec<(Vec<u8>, Tally)>> = self
            .blocks(rows)
            .into_par_iter()
            .map(|block| {
                let solved = self.solve_block(&block, progress)?;
                let mut tally = Tally::default();
                tally.add(self, block.start, &solved.status, &solved.finding);
                Some((self.lines(&solved), tally))
            })
            .collect();
        let (mut lines, mut tally) = (Vec::new(), Tally::default());
        for (of_block, ended) in blocks? {
            lines.extend(of_block);
            tally.merge(ended);
        }
        Some((lines, tally))
    }

    fn has_pairs(&self) -> bool {
        self.case().drive().is_some()
    }

    fn lines(&self, rows: &Rows) -> Vec<u8> {
        let mut text = Vec::with_capacity(rows.status.len() * 24 * (rows.axes.len() + FOUND.len() + 1));
        for (row, status) in rows.status.iter().enumerate() {
            for (axis, numbers) in self.axes().iter().zip(&rows.axes) {
                match &axis.values {
                    // The words of the table of keys need no quotes.
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                    Values::Words(words, _) => text.extend(words[numbers[row] as usize].bytes()),
                    _ => number(&mut text, numbers[row]),
                }
                text.push(b',');
            }
            number(&mut text, rows.elastic_angle_rad[row] * ARCSEC_PER_RAD);
            if self.has_pairs() {
                for value in [
                    rows.alpha_deceleration_rad[row] * ARCSEC_PER_RAD,
                    rows.alpha_equal_speed_rad[row] * ARCSEC_PER_RAD,
                    rows.residual[row],
                    rows.hold_preload_N[row],
                ] {
                    text.push(b',');
                    number(&mut text, value);
                }
            }
            for column in &rows.costs {
                text.push(b',');
                number(&mut text, column[row]);
            }
            if let Some(&finding) = rows.finding.get(row) {
                text.push(b',');
                let word = usize::from(finding).checked_sub(1).and_then(|place| UNBUILDABLE.get(place));
                text.extend(word.map_or("", |word| word).bytes());
            }
            text.push(b',');
            text.extend(STATUSES.get(usize::from(*status)).map_or("", |name| name).bytes());
            text.push(b'\n');
        }
        text
    }
}

/// The shortest text that reads back the same; nothing for what is no number.
fn number(text: &mut Vec<u8>, value: f64) {
    if value.is_finite() {
        // Into memory, which takes everything.
        let _ = serde_json::to_writer(text, &value);
    } else if value.is_infinite() {
        let _ = text.write_all(if value > 0.0 { b"inf" } else { b"-inf" });
    }
}
