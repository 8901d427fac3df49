//! `replay --alerts`: writes a line when an alert is raised, changes or ends.

use std::io;
use std::path::Path;

use super::line_file::LineFile;
use crate::app::AppError;
use fusion::time::Time;
use picture::conflicts::Outlook;
use picture::{Picture, PictureMaker};
use service::live::{AlertJson, AlertMonitor, AlertSettings, PredictionPicture};
use service::state::AlertDecision;
use site::areas::Areas;
use site::config::Config;

/// File of alerts, and the state from which they are raised.
pub(super) struct AlertFile {
    alerts: AlertMonitor,
    file: LineFile,
}

impl AlertFile {
    /// Creates the file. `decisions` are the operator actions made during the recording.
    pub(super) fn create(
        path: &Path,
        config: &Config,
        decisions: Vec<AlertDecision>,
    ) -> Result<Self, AppError> {
        let settings = AlertSettings::new(&config.alerts, &Areas::load(&config.areas)?)?;
        // Alerts are evaluated from the start of the recording, in its own times.
        let mut alerts = AlertMonitor::new(settings, Time::default());
        alerts.plan(decisions);
        Ok(Self { alerts, file: LineFile::create(path)? })
    }

    /// Updates the alerts from the picture of a slot and from predicted entries. Changes are written if the slot `is_wanted`.
    pub(super) fn note(
        &mut self,
        picture: &Picture,
        ahead: Option<PredictionPicture<'_>>,
        maker: &PictureMaker,
        is_wanted: bool,
    ) -> io::Result<()> {
        self.alerts.note_picture(picture, maker);
        if let Some(ahead) = ahead {
            self.alerts.note_approaches(ahead, maker);
        }
        self.write(is_wanted)
    }

    /// Updates the alerts from the conflicts of a second. Changes are written if `is_wanted`.
    pub(super) fn note_outlook(&mut self, outlook: &Outlook, is_wanted: bool) -> io::Result<()> {
        self.alerts.note_outlook(outlook);
        self.write(is_wanted)
    }

    fn write(&mut self, is_wanted: bool) -> io::Result<()> {
        let changes = self.alerts.take_changes();
        let mut written = changes.iter().filter(|_| is_wanted);
        written.try_for_each(|(_, alert)| self.file.write(&AlertJson::from(alert)))
    }

    /// Flushes the file.
    pub(super) fn finish(self) -> io::Result<()> {
        self.file.finish()
    }
}
