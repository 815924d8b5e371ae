//! How the rows of a sweep ended, for people: how many without solution, and of numbers that cannot be together why.

use std::collections::BTreeMap;

use cbpt_core::InvalidInput;

use super::Plan;
use super::rows::{INVALID_INPUT, STATUSES};

/// Rows counted by how they ended.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    counts: [u64; STATUSES.len()],
    /// By field and rule, of which there are few; each row has other numbers.
    reasons: BTreeMap<(String, String), Reason>,
}

#[derive(Debug, Clone)]
struct Reason {
    rows: u64,
    first: u64,
    why: InvalidInput,
}

/// More reasons than these are only counted.
const MOST_REASONS: usize = 6;

impl Tally {
    /// Counts rows of a plan, the first of which is `start`, by their codes.
    pub fn add(&mut self, plan: &Plan, start: u64, status: &[u8]) {
        for (row, &code) in (start..).zip(status) {
            let Some(count) = self.counts.get_mut(usize::from(code)) else { continue };
            *count += 1;
            if STATUSES[usize::from(code)] == INVALID_INPUT
                && let Some(why) = plan.reason(row)
            {
                self.put(Reason { rows: 1, first: row, why });
            }
        }
    }

    /// Counts what another has counted.
    pub fn merge(&mut self, other: Self) {
        for (mine, theirs) in self.counts.iter_mut().zip(other.counts) {
            *mine += theirs;
        }
        other.reasons.into_values().for_each(|reason| self.put(reason));
    }

    fn put(&mut self, reason: Reason) {
        let key = (reason.why.field.clone(), reason.why.required.clone());
        match self.reasons.get_mut(&key) {
            None => {
                self.reasons.insert(key, reason);
            }
            Some(known) => {
                known.rows += reason.rows;
                if reason.first < known.first {
                    (known.first, known.why) = (reason.first, reason.why);
                }
            }
        }
    }

    /// Some lines; nothing where every row has its numbers.
    pub fn text(&self) -> Option<String> {
        let all: u64 = self.counts.iter().sum();
        let ended = || STATUSES.iter().zip(self.counts).skip(1).filter(|(_, count)| *count > 0);
        ended().next()?;
        let counts: Vec<String> = ended().map(|(name, count)| format!("{name} {count}")).collect();
        let mut lines = vec![format!("of {all} rows solved now: {}", counts.join(", "))];
        let mut reasons: Vec<&Reason> = self.reasons.values().collect();
        reasons.sort_by_key(|reason| (std::cmp::Reverse(reason.rows), reason.first));
        for Reason { rows, first, why } in reasons.iter().take(MOST_REASONS) {
            lines.push(format!("  {INVALID_INPUT}: {rows} such as row {}: {why}", first + 1));
        }
        if reasons.len() > MOST_REASONS {
            lines.push(format!("  {INVALID_INPUT}: {} further reasons", reasons.len() - MOST_REASONS));
        }
        Some(lines.join("\n"))
    }
}
