//! Summary of a sweep for people: how many rows have no solution, why the numbers of a row contradict each other, and how
//! many rows have a drive that cannot be built.

use std::collections::BTreeMap;

use cbpt_core::findings::UNBUILDABLE;
use cbpt_core::{Finding, InvalidInput};

use super::Plan;
use super::rows::{INVALID_INPUT, STATUSES};

/// Rows counted by how they ended.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    counts: [u64; STATUSES.len()],
    /// By field and rule, of which there are few; each row has other numbers.
    reasons: BTreeMap<(String, String), Reason>,
    unbuildable: [Option<Unbuildable>; UNBUILDABLE.len()],
}

#[derive(Debug, Clone)]
struct Unbuildable {
    rows: u64,
    first: u64,
    finding: Finding,
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
    /// Counts rows of a plan, the first of which is `start`, by the codes of their statuses and, where drives vary, of their
    /// findings.
    pub fn add(&mut self, plan: &Plan, start: u64, status: &[u8], finding: &[u8]) {
        for (row, &code) in (start..).zip(finding).filter(|(_, code)| **code > 0) {
            let Some(known) = self.unbuildable.get_mut(usize::from(code) - 1) else { continue };
            match known {
                Some(known) => known.rows += 1,
                None => {
                    *known = plan.finding(row).map(|finding| Unbuildable { rows: 1, first: row, finding });
                }
            }
        }
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
        for (mine, theirs) in self.unbuildable.iter_mut().zip(other.unbuildable) {
            let Some(theirs) = theirs else { continue };
            match mine {
                None => *mine = Some(theirs),
                Some(mine) => {
                    mine.rows += theirs.rows;
                    if theirs.first < mine.first {
                        (mine.first, mine.finding) = (theirs.first, theirs.finding);
                    }
                }
            }
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

    /// Some lines; `None` if every row has a solution and a drive that can be built.
    pub fn text(&self) -> Option<String> {
        let texts: Vec<String> = [self.ended(), self.findings()].into_iter().flatten().collect();
        (!texts.is_empty()).then(|| texts.join("\n"))
    }

    fn findings(&self) -> Option<String> {
        let found: Vec<&Unbuildable> = self.unbuildable.iter().flatten().collect();
        let (all, rows) = (self.counts.iter().sum::<u64>(), found.iter().map(|each| each.rows).sum::<u64>());
        let mut lines = vec![format!(
            "of {all} rows solved now, {rows} have a drive that cannot be built, whatever their status; the finding column \
             marks them"
        )];
        lines.extend(found.iter().map(|Unbuildable { rows, first, finding }| {
            format!(
                "  {}: {rows} rows, for example row {}: {} ({})",
                finding.code,
                first + 1,
                finding.message,
                finding.pair
            )
        }));
        (!found.is_empty()).then(|| lines.join("\n"))
    }

    /// How many rows have no numbers, or special ones.
    fn ended(&self) -> Option<String> {
        let all: u64 = self.counts.iter().sum();
        let ended = || STATUSES.iter().zip(self.counts).skip(1).filter(|(_, count)| *count > 0);
        ended().next()?;
        let counts: Vec<String> = ended().map(|(name, count)| format!("{name} {count}")).collect();
        let mut lines = vec![format!("of {all} rows solved now: {}", counts.join(", "))];
        let mut reasons: Vec<&Reason> = self.reasons.values().collect();
        reasons.sort_by_key(|reason| (std::cmp::Reverse(reason.rows), reason.first));
        for Reason { rows, first, why } in reasons.iter().take(MOST_REASONS) {
            lines.push(format!("  {INVALID_INPUT}: {rows} rows, for example row {}: {why}", first + 1));
        }
        if reasons.len() > MOST_REASONS {
            lines.push(format!("  {INVALID_INPUT}: {} other reasons", reasons.len() - MOST_REASONS));
        }
        Some(lines.join("\n"))
    }
}
