//! `encode`: encodes the lines of `decode` as ASTERIX.

use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use super::edition::{EditionOf, editions};
use super::{CommandResult, Outcome};
use input::json::{Editions, Encoder};

/// Encodes the lines printed by `decode` as ASTERIX
///
/// The output of `decode` is restored octet by octet, including blocks of unknown categories and octets that could not be read.
/// From a pcap only the blocks are restored, without the frames. Lines may also be written by hand or by a program: {"cat":48,
/// "items":{"010":{"sac":25, "sic":200}, "140":37230.25, "040":{"rho_m":1852, "theta_deg":90}}} is a block of one record. Lines
/// with the same `block` make one block.
///
/// A line that cannot be encoded is reported on standard error and left out; the exit code is then 1.
#[derive(clap::Args, Debug, Default)]
pub struct Args {
    /// File of lines, or - for standard input
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// File to write raw ASTERIX to, or - for standard output
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Edition of lines that do not name theirs: 2.1 for CAT021, or 48:1.31 for another category. May be given several times
    #[arg(long, value_name = "[N:]EDITION")]
    pub edition: Vec<EditionOf>,
}

/// A file that cannot be opened or written.
#[derive(Debug, thiserror::Error)]
#[error("{name}: cannot be {what}: {cause}; check the path, its permissions and the disk")]
struct EncodeError {
    name: String,
    what: &'static str,
    cause: io::Error,
}

/// Maximum number of invalid lines that are reported one by one; further ones are counted.
const NAMED: u64 = 20;

/// Maximum length of a line, in octets: well above a block of 65,535 octets in hexadecimal or as items.
const LONGEST_LINE: u64 = 16 << 20;

/// Encodes the input into the output.
///
/// # Errors
/// A file cannot be opened, read or written, or an edition does not exist.
pub fn run(args: &Args) -> CommandResult {
    let encoder = Encoder::new(editions(Editions::default(), &args.edition, None)?);
    let refused = |path: &Path, what| {
        let name = path.display().to_string();
        move |cause| EncodeError { name, what, cause }
    };
    let input: Box<dyn Read> = if args.input == Path::new("-") {
        Box::new(io::stdin().lock())
    } else {
        #[expect(clippy::disallowed_methods, reason = "the lines are read here")]
        let file = std::fs::File::open(&args.input).map_err(refused(&args.input, "opened"))?;
        Box::new(file)
    };
    let output: Box<dyn Write> = if args.output == Path::new("-") {
        Box::new(io::stdout().lock())
    } else {
        #[expect(clippy::disallowed_methods, reason = "the blocks are written here")]
        let file = std::fs::File::create(&args.output).map_err(refused(&args.output, "created"))?;
        Box::new(file)
    };
    encode(encoder, &args.input.display().to_string(), BufReader::new(input), BufWriter::new(output))
}

/// Encodes the input line by line.
fn encode(
    mut encoder: Encoder,
    name: &str,
    mut input: impl BufRead,
    mut output: impl Write,
) -> CommandResult {
    let (mut line, mut octets) = (Vec::new(), Vec::new());
    let (mut number, mut bad) = (0_u64, 0_u64);
    loop {
        line.clear();
        let read = (&mut input).take(LONGEST_LINE).read_until(b'\n', &mut line);
        if read.map_err(|cause| EncodeError { name: name.to_owned(), what: "read", cause })? == 0 {
            break;
        }
        number += 1;
        if line.trim_ascii().is_empty() {
            continue;
        }
        let result = match std::str::from_utf8(&line) {
            Ok(line) => encoder.line(line, &mut octets).map_err(|error| error.to_string()),
            Err(_) => Err("is no text".to_owned()),
        };
        if let Err(error) = result {
            bad += 1;
            if bad <= NAMED {
                let _ = writeln!(io::stderr(), "{name}: line {number}: {error}");
            }
        }
        output.write_all(&octets)?;
        octets.clear();
    }
    encoder.finish(&mut octets);
    output.write_all(&octets)?;
    output.flush()?;
    if bad == 0 {
        return Ok(Outcome::Done);
    }
    let plural = if bad == 1 { "" } else { "s" };
    let _ = writeln!(io::stderr(), "{bad} line{plural} of {number} left out");
    Ok(Outcome::Incomplete)
}
