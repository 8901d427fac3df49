//! `replay --alerts`: a line for each alert as it is raised, changes and ends.

use std::io;
use std::path::Path;

use super::line_file::LineFile;
use crate::app::Failure;
use crate::areas::Areas;
use crate::config::Config;
use crate::conflicts::Outlook;
use crate::live::{Ahead, AlertJson, AlertSettings, Alerts};
use crate::picture::{Picture, PictureMaker};
use crate::state::AlertDecision;
use fusion::time::Time;

/// The file, and the alerts that are written into it.
pub(super) struct AlertFile {
    alerts: Alerts,
    file: LineFile,
}

impl AlertFile {
    /// Creates it; the decisions are those that were made while it was recorded.
    pub(super) fn create(
        path: &Path,
        config: &Config,
        decisions: Vec<AlertDecision>,
    ) -> Result<Self, Failure> {
        let settings = AlertSettings::new(&config.alerts, &Areas::load(&config.areas)?)?;
        // A recording has times of its own: it is looked at from its start.
        let mut alerts = Alerts::new(settings, Time::default());
        alerts.plan(decisions);
        Ok(Self { alerts, file: LineFile::create(path)? })
    }

    /// Looks at a slot's picture, and at what is ahead; what changes is written where that slot `is_wanted`.
    pub(super) fn note(
        &mut self,
        picture: &Picture,
        ahead: Option<Ahead<'_>>,
        maker: &PictureMaker,
        is_wanted: bool,
    ) -> io::Result<()> {
        self.alerts.note_picture(picture, maker);
        if let Some(ahead) = ahead {
            self.alerts.note_approaches(ahead, maker);
        }
        self.write(is_wanted)
    }

    /// The same of the conflicts of a second.
    pub(super) fn note_outlook(&mut self, outlook: &Outlook, is_wanted: bool) -> io::Result<()> {
        self.alerts.note_outlook(outlook);
        self.write(is_wanted)
    }

    fn write(&mut self, is_wanted: bool) -> io::Result<()> {
        let changes = self.alerts.take_changes();
        let mut written = changes.iter().filter(|_| is_wanted);
        written.try_for_each(|(_, alert)| self.file.write(&AlertJson::from(alert)))
    }

    /// Completes it.
    pub(super) fn finish(self) -> io::Result<()> {
        self.file.finish()
    }
}
