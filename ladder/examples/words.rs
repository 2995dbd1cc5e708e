//! Prints the words of a random-number generator as raw bytes, little end first, until the reader has enough; for
//! batteries of statistical tests (see `scripts/numbers`).

use ladder::Words;
use std::io::Write;
use std::process::ExitCode;

/// Words of one write.
const CHUNK: usize = 16_384;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let source = arguments.first().and_then(|wanted| Words::ALL.iter().find(|(name, _)| name == wanted));
    let seed = arguments.get(1).map_or(Ok(1), |seed| seed.parse::<u64>());
    let (Some((_, source)), Ok(seed), true) = (source, seed, arguments.len() <= 2) else {
        let names: Vec<&str> = Words::ALL.iter().map(|(name, _)| *name).collect();
        eprintln!("usage: words GENERATOR [SEED], the generator one of {}", names.join(", "));
        return ExitCode::from(2);
    };
    let (mut words, mut out) = (source.from_seed(seed), std::io::stdout().lock());
    let mut bytes = Vec::with_capacity(4 * CHUNK);
    loop {
        bytes.clear();
        bytes.extend(words.by_ref().take(CHUNK).flat_map(u32::to_le_bytes));
        // A battery that has enough closes the pipe.
        match out.write_all(&bytes) {
            Ok(()) => {}
            Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => return ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("words: cannot write: {error}");
                return ExitCode::FAILURE;
            }
        }
    }
}
