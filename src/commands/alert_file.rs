//! `replay --alerts`: a line for each alert as it is raised, changes and ends.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::app::Failure;
use crate::areas::AlertAreas;
use crate::config::Config;
use crate::live::{AlertJson, Alerts, Outlook};
use crate::picture::{Picture, PictureMaker};
use fusion::time::Time;

/// The file, and the alerts that are written into it.
pub(super) struct AlertFile {
    alerts: Alerts,
    path: PathBuf,
    out: BufWriter<File>,
}

impl AlertFile {
    /// Creates it.
    pub(super) fn create(path: &Path, config: &Config) -> Result<Self, Failure> {
        // A recording has times of its own: it is looked at from its start.
        let alerts = Alerts::new(AlertAreas::load(&config.areas)?, Time::default());
        #[expect(clippy::disallowed_methods, reason = "the file that --alerts names")]
        let file = File::create(path).map_err(|error| unwritten(path, &error))?;
        Ok(Self { alerts, path: path.to_owned(), out: BufWriter::new(file) })
    }

    /// Looks at a slot's picture, and at what is ahead; what changes is written where that slot `is_wanted`.
    pub(super) fn note(
        &mut self,
        picture: &Picture,
        outlook: Option<Outlook<'_>>,
        maker: &PictureMaker,
        is_wanted: bool,
    ) -> io::Result<()> {
        self.alerts.note_picture(picture, maker);
        if let Some(outlook) = outlook {
            self.alerts.note_outlook(outlook, maker);
        }
        let changes = self.alerts.take_changes();
        let mut written = changes.iter().filter(|_| is_wanted);
        written.try_for_each(|(_, alert)| self.write(&AlertJson::from(alert)))
    }

    fn write(&mut self, alert: &AlertJson) -> io::Result<()> {
        let line = serde_json::to_string(alert)? + "\n";
        self.out.write_all(line.as_bytes()).map_err(|error| unwritten(&self.path, &error))
    }

    /// Completes it.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.out.flush().map_err(|error| unwritten(&self.path, &error))
    }
}

fn unwritten(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: cannot be written: {error}", path.display()))
}
