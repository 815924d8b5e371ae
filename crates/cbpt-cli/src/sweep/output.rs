//! A CSV file that grows chunk by chunk. A sweep that was interrupted continues where it stopped.
//!
//! Beside `result.csv` stands `result.csv.sweep`, a record of the plan, of the rows that are done and of the length and the
//! SHA-256 of the file up to them. A chunk is written and flushed to the disk before the record says so, and the record is replaced whole;
//! so the file always holds at least the rows of the record, and a sweep that continues cuts off anything beyond them.
//! A file with more than the rows of a finished sweep was changed by someone else, so it is refused.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::Plan;
use crate::exit::{Failure, keep_input};
use crate::whole;

/// An output with what is done of it.
#[derive(Debug)]
pub struct CsvOutput {
    path: PathBuf,
    file: File,
    plan: Value,
    rows: u64,
    done: u64,
    bytes: u64,
    /// Of these bytes.
    sum: Sha256,
}

/// What is there is read anew in parts of so many bytes.
const PART: usize = 1 << 20;

impl CsvOutput {
    /// Opens the output of a plan where it stands, or begins it; `fresh` begins it anew, whatever is there.
    ///
    /// # Errors
    /// A file that the plan was read from, an output of another plan, or one that another process writes, or that is not what its record says; and a file that
    /// cannot be written.
    pub fn open(plan: &Plan, path: &Path, fresh: bool) -> Result<Self, Failure> {
        keep_input(path, plan.sources())?;
        let path = &whole::followed(path).map_err(|error| Failure::Write { path: path.to_owned(), error })?;
        // An empty file is one that was killed before its first record, or is just begun by another process.
        let there = fs::metadata(path).is_ok_and(|found| !found.is_file() || found.len() > 0);
        let record = if fresh { None } else { read_record(path)? };
        if let Some(record) = &record {
            same_plan(path, &record["plan"], &plan.record())?;
            is_there(path, record)?;
        } else if there && !fresh {
            return Err(Failure::Usage(format!(
                "{}: the file exists but has no record of a sweep beside it; give another --out, or --fresh to replace \
                 the file",
                path.display()
            )));
        }
        let written = |error| Failure::Write { path: path.to_owned(), error };
        let options = || File::options().read(true).write(true).create(true).truncate(false).open(path);
        let file = options().map_err(written)?;
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(Failure::Usage(format!(
                "{}: another process is writing this file; wait for it, or give another --out",
                path.display()
            )));
        }
        let mut output = Self {
            path: path.to_owned(),
            file,
            plan: plan.record(),
            rows: plan.rows(),
            done: 0,
            bytes: 0,
            sum: Sha256::new(),
        };
        match record.filter(|record| record["bytes"].as_u64().is_some_and(|bytes| bytes > 0)) {
            Some(record) => output.take_up(&record)?,
            None => output.begin(plan)?,
        }
        Ok(output)
    }

    /// Rows that are on disk.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Whether all are.
    pub fn is_complete(&self) -> bool {
        self.done >= self.rows
    }

    fn begin(&mut self, plan: &Plan) -> Result<(), Failure> {
        self.record()?;
        self.file.set_len(0).map_err(|error| self.cannot(error))?;
        self.append(&plan.csv_header(), 0)
    }

    fn take_up(&mut self, record: &Value) -> Result<(), Failure> {
        let number = |key: &str| record[key].as_u64().unwrap_or(0);
        (self.done, self.bytes) = (number("rows_done"), number("bytes"));
        let length = self.file.metadata().map_err(|error| self.cannot(error))?.len();
        let changed = |what: &str| {
            Failure::Usage(format!(
                "{}: {what}, so the file was changed after the sweep wrote it; give another --out, or --fresh to start again",
                self.path.display()
            ))
        };
        if length < self.bytes {
            return Err(changed(&format!("the file has {length} bytes, its record says {}", self.bytes)));
        }
        self.sum = self.read_sum().map_err(|error| self.cannot(error))?;
        if record["sha256"] != self.digits() {
            return Err(changed("the rows differ from those of its record"));
        }
        if length > self.bytes && self.is_complete() {
            let more = length - self.bytes;
            return Err(changed(&format!("the file has {more} bytes after the rows of the finished sweep")));
        }
        if length > self.bytes {
            self.file.set_len(self.bytes).map_err(|error| self.cannot(error))?;
        }
        Ok(())
    }

    /// Adds the lines of the next rows, and returns when they are on disk.
    ///
    /// # Errors
    /// Where they cannot be written; the rows written before stay, and a later sweep continues after them.
    pub fn append(&mut self, lines: &[u8], rows: u64) -> Result<(), Failure> {
        let write = |file: &mut File| {
            file.seek(SeekFrom::Start(self.bytes))?;
            file.write_all(lines)?;
            file.sync_data()
        };
        write(&mut self.file).and_then(|()| self.is_at_its_place()).map_err(|error| self.cannot(error))?;
        self.done += rows;
        self.bytes += lines.len() as u64;
        self.sum.update(lines);
        self.record()
    }

    /// That the file which grows is the one that its name leads to. Where there are no numbers of files, an open file cannot be
    /// deleted.
    fn is_at_its_place(&self) -> io::Result<()> {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let (here, there) = (self.file.metadata()?, fs::metadata(&self.path).ok());
            if there.is_none_or(|there| (there.dev(), there.ino()) != (here.dev(), here.ino())) {
                return Err(io::Error::other("the file was deleted or replaced while the sweep wrote it"));
            }
        }
        Ok(())
    }

    /// The sum of what the record says is there, read anew.
    fn read_sum(&self) -> io::Result<Sha256> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(0))?;
        let mut left = file.take(self.bytes);
        let (mut sum, mut part) = (Sha256::new(), vec![0; PART]);
        loop {
            match left.read(&mut part)? {
                0 => return Ok(sum),
                read => sum.update(&part[..read]),
            }
        }
    }

    fn digits(&self) -> String {
        format!("{:x}", self.sum.clone().finalize())
    }

    /// Puts the record in the place of the one before.
    fn record(&self) -> Result<(), Failure> {
        let record = json!({
            "rows_done": self.done,
            "bytes": self.bytes,
            "sha256": self.digits(),
            "plan": self.plan,
        });
        let path = record_path(&self.path);
        whole::write(&path, format!("{record:#}\n").as_bytes())
            .map_err(|error| Failure::Write { path, error })
    }

    fn cannot(&self, error: io::Error) -> Failure {
        Failure::Write { path: self.path.clone(), error }
    }
}

/// The record beside an output.
fn record_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".sweep");
    name.into()
}

fn read_record(path: &Path) -> Result<Option<Value>, Failure> {
    let record = record_path(path);
    let text = match fs::read(&record) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(Failure::Usage(format!("{}: cannot be read: {error}", record.display()))),
    };
    let found: Option<Value> = serde_json::from_slice(&text).ok();
    match found.filter(|found| found["plan"].is_object()) {
        Some(found) => Ok(Some(found)),
        None => Err(Failure::Usage(format!(
            "{}: is not a record of a sweep; give another --out, or --fresh to start again",
            record.display()
        ))),
    }
}

/// Refuses a record whose file is gone: it may only be elsewhere, and a new one would take its record.
fn is_there(path: &Path, record: &Value) -> Result<(), Failure> {
    let gone = fs::metadata(path).is_err_and(|error| error.kind() == io::ErrorKind::NotFound);
    if !gone || record["bytes"].as_u64().is_none_or(|bytes| bytes == 0) {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{}: the file is missing, but its record {} says that {} rows were written; put the file back, or give --fresh to start again",
        path.display(),
        record_path(path).display(),
        record["rows_done"]
    )))
}

/// Refuses to go on with the output of another plan, and says what differs.
///
/// # Errors
/// Where the two are not the same.
pub fn same_plan(path: &Path, there: &Value, wanted: &Value) -> Result<(), Failure> {
    if there == wanted {
        return Ok(());
    }
    let keys = |of: &Value| {
        of.as_object().into_iter().flatten().map(|(key, _)| key.clone()).collect::<BTreeSet<_>>()
    };
    let differing: Vec<String> = keys(wanted)
        .union(&keys(there))
        .filter(|key| there[*key] != wanted[*key])
        .map(|key| match (&there[key], &wanted[key]) {
            (Value::String(_), _) if key == "case" => "the case".to_owned(),
            (Value::Array(there), Value::Array(wanted)) if key == "axes" => differing_axes(there, wanted),
            (there, wanted) => format!("{key} ({there} there, {wanted} here)"),
        })
        .collect();
    Err(Failure::Usage(format!(
        "{}: the file holds rows of another plan, which differs in {}; give another --out, or --fresh to replace the file",
        path.display(),
        if differing.is_empty() { "its record".to_owned() } else { differing.join(", ") }
    )))
}

/// The axes that are not in both, or that have other values.
fn differing_axes(there: &[Value], wanted: &[Value]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for axis in there.iter().chain(wanted) {
        let name = axis["name"].as_str().unwrap_or_default();
        let in_both = there.contains(axis) && wanted.contains(axis);
        if !in_both && !names.contains(&name) {
            names.push(name);
        }
    }
    if names.is_empty() { "the order of the axes".into() } else { format!("the axes {}", names.join(", ")) }
}
