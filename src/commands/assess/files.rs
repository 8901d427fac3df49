//! Files of `assess`: their hashes, and the recordings.

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use jiff::civil::Date;
use sha2::{Digest, Sha256};
use tracing::{error, warn};

use crate::commands::Usage;
use crate::commands::evaluate::files::day_of;
use input::capture::{Capture, MergedCaptures, ReadError, Reception, SiteReceivers, TrailerRules};
use lab::assess::AssessedFile;
use lab::evaluate::Truth;
use site::config::Config;

type FileFailure = Box<dyn Error + Send + Sync>;

/// Default day of files without a date: the first of the epoch, as in `replay`.
const UNDATED: Date = Date::constant(1970, 1, 1);
/// Beginning of variables that override the configuration.
const OVERRIDES: &str = "UTM_FUSION__";
/// Octets that are read at once.
const CHUNK: usize = 1 << 16;

/// Files that were read, with their hashes.
#[derive(Default)]
pub(super) struct Hashed {
    pub(super) files: Vec<AssessedFile>,
}

impl Hashed {
    /// Adds a file.
    pub(super) fn add(&mut self, role: &'static str, path: &Path) -> Result<(), FileFailure> {
        if path == Path::new("-") {
            return Err(Usage(
                "a recording is read twice, and standard input cannot be; name a file".to_owned(),
            )
            .into());
        }
        let failed = |error| {
            format!("{}: cannot be read: {error}; check the path and its permissions", path.display())
        };
        #[expect(clippy::disallowed_methods, reason = "the files that the user names")]
        let mut file = fs::File::open(path).map_err(failed)?;
        let (mut hash, mut octets, mut chunk) = (Sha256::new(), 0, vec![0; CHUNK]);
        loop {
            let count = file.read(&mut chunk).map_err(failed)?;
            if count == 0 {
                break;
            }
            octets += count as u64;
            hash.update(&chunk[..count]);
        }
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        self.push(role, name, octets, hash);
        Ok(())
    }

    /// Adds the variables that override the configuration, if there are any.
    pub(super) fn add_overrides(&mut self) {
        let mut lines: Vec<String> = (std::env::vars_os())
            .filter(|(name, _)| name.to_string_lossy().starts_with(OVERRIDES))
            .map(|(name, value)| format!("{}={}\n", name.to_string_lossy(), value.to_string_lossy()))
            .collect();
        lines.sort();
        if !lines.is_empty() {
            let text = lines.concat();
            let hash = Sha256::new().chain_update(&text);
            self.push("overrides", format!("{OVERRIDES}*"), text.len() as u64, hash);
        }
    }

    fn push(&mut self, role: &'static str, name: String, octets: u64, hash: Sha256) {
        let mut sha256 = String::new();
        for octet in hash.finalize() {
            // Writing to a string cannot fail.
            let _ = write!(sha256, "{octet:02x}");
        }
        self.files.push(AssessedFile { role, name, octets, sha256 });
    }
}

/// Open recordings.
pub(super) struct Opened {
    merged: MergedCaptures,
    is_damaged: bool,
}

impl Opened {
    /// Opens recordings of a site. The day of files without dates is `date`, else that of the truth.
    pub(super) fn open(
        inputs: &[PathBuf],
        config: &Config,
        date: Option<Date>,
        truth: Option<&Truth>,
    ) -> Result<Self, FileFailure> {
        let (trailers, receivers) = (TrailerRules::of(config), SiteReceivers::of(config));
        let open = |path: &PathBuf| {
            Ok::<_, FileFailure>(
                Capture::open(path)?.with_trailers(trailers.clone()).with_receivers(&receivers),
            )
        };
        let captures = inputs.iter().map(open).collect::<Result<Vec<_>, _>>()?;
        let date = match (date, truth) {
            (Some(date), _) => date,
            (None, Some(truth)) => day_of(inputs, truth)?,
            (None, None) => {
                for capture in captures.iter().filter(|capture| !capture.is_dated()) {
                    let capture = capture.name();
                    warn!(capture, from = %UNDATED, "the format has no date: give it as --date YYYY-MM-DD");
                }
                UNDATED
            }
        };
        let merged = MergedCaptures::new(captures, date).with_editions(config.editions());
        Ok(Self { merged, is_damaged: false })
    }

    /// The receptions, up to where a file is damaged.
    pub(super) fn receptions(&mut self) -> impl Iterator<Item = Result<Reception, ReadError>> {
        let Self { merged, is_damaged } = self;
        merged.filter_map(|next| match next {
            Ok(reception) => Some(Ok(reception)),
            Err(damage) => {
                error!(%damage, "an input cannot be read on");
                *is_damaged = true;
                None
            }
        })
    }

    pub(super) fn is_damaged(&self) -> bool {
        self.is_damaged
    }

    /// Frames without a datagram, by reason.
    pub(super) fn skipped(&self) -> String {
        let skipped = self.merged.captures().filter(|capture| capture.skipped().total() > 0);
        skipped.map(|capture| capture.skipped().to_string()).collect::<Vec<_>>().join("; ")
    }
}

/// Writes a file.
pub(super) fn write(path: &Path, text: &str) -> Result<(), FileFailure> {
    fs::write(path, text).map_err(|error| format!("{}: cannot be written: {error}", path.display()).into())
}
