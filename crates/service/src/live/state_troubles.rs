//! Faults of the files in `[state] dir`. A restart would lose what cannot be written, and has lost what was damaged.

use std::collections::BTreeMap;

use jiff::SignedDuration;

use super::alerts::{ServiceFault, Severity};
use crate::state::{FileHealth, StateHealth};
use fusion::time::Time;

/// Time for which damage is reported.
const REPORTED: SignedDuration = SignedDuration::from_mins(10);

/// Faults of the files at `at`.
pub fn state_troubles(health: &StateHealth, at: Time) -> Vec<ServiceFault> {
    let files = health.all();
    let trouble =
        |about: &'static str, text| ServiceFault { about: about.into(), severity: Severity::Warning, text };
    let failing = unwritten(&files).map(|text| trouble(ServiceFault::STATE, text));
    let damaged = damaged(&files, at).map(|text| trouble(ServiceFault::DAMAGE, text));
    failing.into_iter().chain(damaged).collect()
}

fn unwritten(files: &BTreeMap<String, FileHealth>) -> Option<String> {
    let failing = files.iter().filter_map(|(name, file)| Some((name.as_str(), file.failing.as_deref()?)));
    let (names, errors): (Vec<_>, Vec<_>) = failing.unzip();
    let error = errors.first()?;
    Some(format!("state cannot be written, so a restart would lose it: {}: {error}", names.join(", ")))
}

fn damaged(files: &BTreeMap<String, FileHealth>, at: Time) -> Option<String> {
    let recent = files.values().filter_map(|file| {
        let (found, aside) = file.aside.as_ref()?;
        (at.nanos().abs_diff(found.nanos()) < REPORTED.as_nanos() as u64).then_some(aside.as_str())
    });
    let recent: Vec<&str> = recent.collect();
    (!recent.is_empty())
        .then(|| format!("damaged state files were set aside, and others begun: {}", recent.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state::NUMBERS;
    use fusion::time::SECOND;

    #[test]
    fn write_failure_is_reported_until_a_write_succeeds() {
        let health = StateHealth::default();
        let at = Time::from_nanos(1_795_168_800 * SECOND);
        assert!(state_troubles(&health, at).is_empty());
        assert!(health.note_failure(NUMBERS, &"no space left"));
        assert!(!health.note_failure(NUMBERS, &"no space left"));
        let troubles = state_troubles(&health, at);
        assert_eq!((troubles.len(), &*troubles[0].about), (1, ServiceFault::STATE));
        assert!(troubles[0].text.contains("numbers.json: no space left"), "{}", troubles[0].text);
        assert!(health.note_success(NUMBERS) && !health.note_success(NUMBERS));
        assert!(state_troubles(&health, at).is_empty());
    }

    #[test]
    fn damage_is_reported_for_ten_minutes_and_counted() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-troubles-{}", std::process::id()));
        std::fs::create_dir_all(&directory).unwrap();
        std::fs::write(directory.join(NUMBERS), "x").unwrap();
        let (health, at) = (StateHealth::default(), Time::from_nanos(1_795_168_800 * SECOND));
        health.set_aside(&directory, NUMBERS, "numbers", &"it is no JSON", at);
        let troubles = state_troubles(&health, at);
        assert_eq!((troubles.len(), &*troubles[0].about), (1, ServiceFault::DAMAGE));
        assert!(troubles[0].text.contains("numbers.json.damaged-2026"), "{}", troubles[0].text);
        assert!(state_troubles(&health, at + REPORTED).is_empty());
        assert_eq!(health.all()[NUMBERS].damaged, 1);
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
