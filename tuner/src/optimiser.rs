//! The optimiser: a Python process that proposes points, with requests and answers line by line. See
//! `tuner/optimiser.py`.

use crate::error::Error;
use crate::space::Space;
use files::atomic_file::reason;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The program that Python runs.
const PROGRAM: &str = include_str!("../optimiser.py");
/// The packages that it needs, in a checkout of the repository.
const REQUIREMENTS: &str = "tuner/requirements.lock";
/// The script that installs them and runs Python, in a checkout.
const SCRIPT: &str = "scripts/python";

/// The running process.
pub(crate) struct Optimiser {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    /// How it was started, for messages.
    python: PathBuf,
    /// The library and its version.
    pub(crate) name: String,
}

/// What the optimiser's model has learnt from the measurements.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub(crate) struct Learnt {
    /// The indices of the points, sorted by the model's mean, the best first.
    pub(crate) order: Vec<usize>,
    /// The model's standard deviation of measured values.
    pub(crate) noise: Option<f64>,
    /// The model's length scale of each dimension, in widths of its range. If large, the dimension does not matter.
    pub(crate) length_scales: BTreeMap<String, f64>,
}

impl Optimiser {
    /// Starts the process in `python`, else in that of the checkout, else in `python3`.
    pub(crate) fn start(
        python: Option<&Path>,
        space: &Space,
        initial: u32,
        seed: u32,
    ) -> Result<Self, Error> {
        let checkout = std::env::current_exe().ok().and_then(|path| checkout(&path));
        let python = match (python, &checkout) {
            (Some(python), _) => python.into(),
            (None, Some(root)) => root.join(SCRIPT),
            (None, None) => PathBuf::from("python3"),
        };
        let mut command = Command::new(&python);
        command.args(["-c", PROGRAM]).env("SPPM_REQUIREMENTS", REQUIREMENTS);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let failure = |problem: String| Error::Optimiser { python: python.clone(), problem };
        let mut child =
            command.spawn().map_err(|error| failure(format!("cannot be run: {}", reason(&error))))?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(failure("has no input or output".into()));
        };
        let output = BufReader::new(output);
        let mut optimiser = Self { child, input, output, python, name: String::new() };
        let setup = json!({
            "dimensions": space.dimensions, "start": space.start(), "initial": initial, "seed": seed
        });
        let hello = optimiser.request(&setup)?;
        optimiser.name = field(&hello, "optimiser").map_err(|what| optimiser.failure(&what))?;
        Ok(optimiser)
    }

    /// The next point to try.
    pub(crate) fn ask(&mut self) -> Result<Vec<Value>, Error> {
        let answer = self.request(&json!({ "ask": true }))?;
        field(&answer, "point").map_err(|what| self.failure(&what))
    }

    /// Reports the value that was measured at a point.
    pub(crate) fn tell(&mut self, point: &[Value], value: f64) -> Result<(), Error> {
        self.request(&json!({ "tell": point, "value": value })).map(drop)
    }

    /// Asks what the model has learnt from the `told` points.
    pub(crate) fn conclude(&mut self, told: usize) -> Result<Learnt, Error> {
        let answer = self.request(&json!({ "conclude": true }))?;
        let learnt: Learnt =
            serde_json::from_value(answer).map_err(|error| self.failure(&error.to_string()))?;
        let is_point = |place: &usize| *place < told;
        if learnt.order.len() == told && learnt.order.iter().all(is_point) {
            return Ok(learnt);
        }
        Err(self.failure("an order of points that were never tried"))
    }

    /// Sends a line and waits for the answer.
    fn request(&mut self, request: &Value) -> Result<Value, Error> {
        // If the process has ended, its error output, which `ended` reads, is more useful than the broken pipe.
        let _ = writeln!(self.input, "{request}").and_then(|()| self.input.flush());
        let mut line = String::new();
        let read = self.output.read_line(&mut line);
        match serde_json::from_str::<Value>(&line) {
            Ok(answer) => match answer.get("missing").and_then(Value::as_str) {
                Some(missing) => {
                    Err(Error::NoLibrary { python: self.python.clone(), problem: missing.into() })
                }
                None => Ok(answer),
            },
            Err(_) if read.is_ok() && line.is_empty() => Err(self.ended()),
            Err(error) => Err(self.failure(&error.to_string())),
        }
    }

    fn failure(&self, what: &str) -> Error {
        let problem = format!("did not answer as the optimiser does: {what}");
        Error::Optimiser { python: self.python.clone(), problem }
    }

    /// The error for a process that has ended, with the last line of its error output.
    fn ended(&mut self) -> Error {
        let mut said = Vec::new();
        if let Some(errors) = &mut self.child.stderr {
            let _ = errors.read_to_end(&mut said); // a failed read loses only the message
        }
        let said = String::from_utf8_lossy(&said);
        let last = said.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("it said nothing");
        let problem = format!("the optimiser ended: {}", last.trim());
        Error::Optimiser { python: self.python.clone(), problem }
    }
}

impl Drop for Optimiser {
    fn drop(&mut self) {
        let _ = self.child.kill(); // fails if it has already ended
        let _ = self.child.wait();
    }
}

fn field<T: serde::de::DeserializeOwned>(answer: &Value, name: &str) -> Result<T, String> {
    let value = answer.get(name).ok_or_else(|| format!("no {name} in {answer}"))?;
    serde_json::from_value(value.clone()).map_err(|error| error.to_string())
}

/// The checkout in which the program at `path` was built, if any.
fn checkout(path: &Path) -> Option<PathBuf> {
    let is_checkout = |root: &&Path| [SCRIPT, REQUIREMENTS].iter().all(|file| root.join(file).is_file());
    path.ancestors().skip(1).find(is_checkout).map(Path::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checkout_is_above_the_program() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        assert_eq!(checkout(&root.join("target/release/sppm")).as_deref(), Some(root));
        assert_eq!(checkout(Path::new("/usr/bin/sppm")), None);
    }
}
