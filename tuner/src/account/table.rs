//! Writes all tried points as a table of comma-separated values.

use super::outcome::Outcome;
use crate::error::Error;
use crate::found::Tried;
use fast::Parameters;
use files::atomic_file::{self, Output};
use render::LanesName;
use std::io;
use std::path::Path;

/// Writes a line per point. The last line is the best point, measured again.
pub(crate) fn write(path: &Path, outcome: &Outcome) -> Result<(), Error> {
    let names = Parameters::ALL.iter().map(|parameter| parameter.name);
    let header = ["evaluation", "ratio", "least", "most", "pairs", "lanes"].into_iter().chain(names);
    let again = outcome.found.is_confirmed.then_some(&outcome.found.best);
    let fill = |out: &mut Output| {
        let mut csv = csv::Writer::from_writer(out);
        csv.write_record(header).map_err(io::Error::other)?;
        for (number, tried) in outcome.found.tried.iter().chain(again).enumerate() {
            csv.write_record(record(number + 1, tried)).map_err(io::Error::other)?;
        }
        csv.flush()
    };
    Ok(atomic_file::replace(path, fill)?)
}

fn record(number: usize, Tried { candidate, ratios }: &Tried) -> Vec<String> {
    let [least, most] = ratios.ends();
    let lanes = LanesName::from(candidate.lanes).name();
    let mut fields = vec![number.to_string()];
    fields.extend([ratios.median(), least, most].map(|ratio| format!("{ratio:.5}")));
    fields.extend([ratios.count().to_string(), lanes.into()]);
    fields.extend(candidate.parameters.values().into_iter().map(|value| (value as f32).to_string()));
    fields
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Its number, its ratios from the least to the most and how many they are, and its values in the order of the header.
    #[test]
    fn a_point_is_a_line_of_its_ratios_and_values() {
        let outcome = Outcome::example(vec![0.95, 0.9, 0.91, 0.94, 0.92, 0.93, 0.125], true);
        let fields = record(4, &outcome.found.best);
        assert_eq!(fields[..7], ["4", "0.92000", "0.12500", "0.95000", "7", "emulated", "4"]);
        let values = Parameters::default().values();
        assert_eq!(fields.len(), 6 + values.len());
        let numbers: Vec<f64> = fields[7..].iter().map(|field| field.parse().unwrap()).collect();
        assert_eq!(numbers, values[1..]);
    }
}
