//! The heights of transponders against those of radars: a constant offset of each transponder, applied once it is evident.

pub(super) mod concerns;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::tuning::{
    HEIGHT_APPLIED, HEIGHT_CONTRADICTS, HEIGHT_JUDGED_S, HEIGHT_PRIOR, HEIGHT_RELEASED, HEIGHT_SHARE_SLEW_HZ,
    HEIGHT_SLEW_M_S, HEIGHT_STEP_M, TRANSPONDERS_MAX,
};
use crate::registration::{HeightAlignment, HeightOffset, HeightSums, Sample, height_verdict};
use crate::report::{Identity, SensorIndex};
use crate::time::Time;

/// Heights of all transponders, and of the radars that they are compared with.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct TransponderHeights {
    of: BTreeMap<Identity, OwnHeights>,
    radars: BTreeMap<SensorIndex, JudgedRadar>,
    /// The slot up to which offsets were applied.
    moved: Option<Time>,
}

/// Heights of one transponder.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct OwnHeights {
    by_radar: BTreeMap<SensorIndex, HeightSums>,
    /// Sigma of the lasting error of its heights, metres.
    sigma_m: f64,
    offsets: BTreeMap<SensorIndex, HeightOffset>,
    is_evident: bool,
    applied_m: f64,
    /// Time of the latest radar track compared with it.
    seen: Time,
}

/// The latest verdict on the tracks of one radar.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct JudgedRadar {
    alignment: Option<HeightAlignment>,
    /// Whether tracks have come since the last verdict, and the time of that.
    is_due: bool,
    judged: Option<Time>,
    /// Share of its alignment that is used instead of what the registration finds.
    share: f64,
}

/// How the heights of one transponder are corrected.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct HeightCorrection {
    /// Offset that is subtracted from its heights, metres.
    pub(super) applied_m: f64,
    /// Second moment of the part of a constant offset that is not applied, m².
    pub(super) left_m2: f64,
    /// The offset of heights that contradict a radar's.
    pub(super) contradiction: Option<HeightOffset>,
}

impl OwnHeights {
    fn new(sigma_m: f64, seen: Time) -> Self {
        Self {
            by_radar: BTreeMap::new(),
            sigma_m,
            offsets: BTreeMap::new(),
            is_evident: false,
            applied_m: 0.0,
            seen,
        }
    }

    /// The offset by the radar that has shown most of it.
    fn offset(&self) -> Option<&HeightOffset> {
        self.offsets.values().max_by(|one, other| one.information.total_cmp(&other.information))
    }

    fn correction(&self) -> HeightCorrection {
        let offset = self.offset().copied().unwrap_or_default();
        let HeightOffset { probability, mean_m, variance_m2, .. } = offset;
        // Before any radar has seen it, only the stated accuracy counts.
        let probable = ((probability - HEIGHT_PRIOR) / (1.0 - HEIGHT_PRIOR)).max(0.0);
        let left_m = mean_m - self.applied_m;
        let is_none = (1.0 - probable) * self.applied_m * self.applied_m;
        HeightCorrection {
            applied_m: self.applied_m,
            left_m2: probable * (variance_m2 + left_m * left_m) + is_none,
            contradiction: (self.is_evident || probability > HEIGHT_CONTRADICTS).then_some(offset),
        }
    }

    /// Brings what is applied nearer to what is evident, `dt` seconds after the last time.
    fn apply(&mut self, dt: f64) {
        let offset = self.offset().copied().unwrap_or_default();
        let least = if self.is_evident { HEIGHT_RELEASED } else { HEIGHT_APPLIED };
        self.is_evident = offset.probability > least;
        let wanted_m = if self.is_evident { offset.mean_m } else { 0.0 };
        let wanted_m = (wanted_m / HEIGHT_STEP_M).round() * HEIGHT_STEP_M;
        let most_m = HEIGHT_SLEW_M_S * dt;
        self.applied_m += (wanted_m - self.applied_m).clamp(-most_m, most_m);
    }
}

impl TransponderHeights {
    /// Adds a piece of a radar track of a transponder whose heights are accurate to `sigma_m`.
    pub(super) fn add_segment(
        &mut self,
        identity: Identity,
        radar: SensorIndex,
        sample: &Sample,
        sigma_m: f64,
    ) {
        let own = self.own_heights(identity, sigma_m, sample.time());
        own.sigma_m = sigma_m;
        own.seen = own.seen.max(sample.time());
        own.by_radar.entry(radar).or_insert(HeightSums::NONE).add(sample);
        self.radars.entry(radar).or_default().is_due = true;
    }

    /// Discards the evidence of this radar: it was moved.
    pub(super) fn forget_radar(&mut self, radar: SensorIndex) {
        for own in self.of.values_mut() {
            own.by_radar.remove(&radar);
            own.offsets.remove(&radar);
        }
        self.radars.remove(&radar);
    }

    /// Judges the radars with new tracks, and brings what is applied nearer to what is evident.
    pub(super) fn evaluate_radars(&mut self, now: Time) {
        let dt = self.moved.map_or(0.0, |before| now.seconds_since(before).max(0.0));
        self.moved = Some(now);
        for (&radar, judged) in &mut self.radars {
            let is_fresh = judged.judged.is_some_and(|last| now.seconds_since(last) < HEIGHT_JUDGED_S);
            if !judged.is_due || is_fresh {
                continue;
            }
            (judged.is_due, judged.judged) = (false, Some(now));
            let (mut identities, mut evidence) = (Vec::new(), Vec::new());
            for (identity, own) in &self.of {
                if let Some(sums) = own.by_radar.get(&radar).filter(|sums| sums.is_some()) {
                    identities.push(*identity);
                    evidence.push((*sums, own.sigma_m));
                }
            }
            let Some(verdict) = height_verdict(&evidence) else { continue };
            judged.alignment = Some(verdict.alignment);
            for (identity, offset) in identities.iter().zip(verdict.offsets) {
                if let Some(own) = self.of.get_mut(identity) {
                    own.offsets.insert(radar, offset);
                }
            }
        }
        self.of.values_mut().for_each(|own| own.apply(dt));
        for (radar, judged) in &mut self.radars {
            let is_used = self.of.values().any(|own| own.is_evident && own.offsets.contains_key(radar));
            let step = HEIGHT_SHARE_SLEW_HZ * dt;
            judged.share = (judged.share + if is_used { step } else { -step }).clamp(0.0, 1.0);
        }
    }

    /// Alignment of a radar where transponders' heights have offsets, and the share of it that is used.
    pub(super) fn alignment(&self, radar: SensorIndex) -> Option<(&HeightAlignment, f64)> {
        let judged = self.radars.get(&radar).filter(|judged| judged.share > 0.0)?;
        Some((judged.alignment.as_ref()?, judged.share))
    }

    /// Corrections of heights by identity.
    pub(super) fn corrections(&self) -> BTreeMap<Identity, HeightCorrection> {
        self.of.iter().map(|(identity, own)| (*identity, own.correction())).collect()
    }

    fn own_heights(&mut self, identity: Identity, sigma_m: f64, seen: Time) -> &mut OwnHeights {
        if self.of.len() >= TRANSPONDERS_MAX
            && !self.of.contains_key(&identity)
            && let Some(oldest) = self.of.iter().min_by_key(|(_, own)| own.seen).map(|known| *known.0)
        {
            self.of.remove(&oldest);
        }
        self.of.entry(identity).or_insert_with(|| OwnHeights::new(sigma_m, seen))
    }
}

#[cfg(test)]
mod tests;
