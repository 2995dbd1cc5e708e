//! How long reading a file takes, and how much memory: `measure FILE`. `RAYON_NUM_THREADS=1` for one thread.

use importers::{Request, read};
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: measure FILE");
        return ExitCode::from(2);
    };
    let start = Instant::now();
    match read(Path::new(&path), &Request::default()) {
        Ok(particles) => {
            let count = particles.len().max(1);
            println!("{count} particles in {:.2} s", start.elapsed().as_secs_f64());
            // Linux alone tells.
            let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
            if let Some(peak) = status.lines().find_map(|line| line.strip_prefix("VmHWM:")) {
                let kilobytes: f64 = peak.trim().trim_end_matches(" kB").parse().unwrap_or(f64::NAN);
                println!(
                    "peak {:.0} MB, {:.1} bytes a particle",
                    kilobytes / 1024.0,
                    kilobytes * 1024.0 / count as f64
                );
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
