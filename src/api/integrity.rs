//! `/api/v1/integrity`: whether transponders can be trusted, and what operators say of them.

use std::time::Duration;

use axum::http::StatusCode;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::info;

use super::ask::Ask;
use super::correlations::{problem, refuse_standing};
use super::problem::Problem;
use super::route::Later;
use super::shown::Shown;
use crate::json::rounded;
use crate::live::{Denied, Hub, Integrities, Named, Saying};
use crate::names::without;
use crate::picture::{PictureTrack, ReasonName, Rfc3339, StateName, TransponderId, serial_text};
use fusion::Identity;
use fusion::integrity::{Assessment, Evidence, Trust};
use fusion::slots::SlotGrid;

/// The engine takes words several times per second; without an answer by then the request fails.
const PATIENCE: Duration = Duration::from_secs(2);

const RULE: &str = "a verdict is trusted, distrusted or automatic";

/// What is known of the transponders that were heard in the last hour.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Integrity")]
pub struct IntegrityList {
    /// Of the slot that it is known at.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
    /// Whether it is judged at all: not in the reference profile, nor with `[integrity] action = "off"`.
    computed: bool,
    identities: Vec<IdentityJson>,
}

/// What is known of a transponder.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "IdentityIntegrity")]
pub struct IdentityJson {
    /// Its serial number, as it is named in the path.
    identity: String,
    uas_id: TransponderId,
    /// Id of its track, where it has one in the latest slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    track_id: Option<String>,
    state: StateName,
    /// When the state began.
    since: Rfc3339,
    /// Natural logarithm of how much likelier a lie is than none, by radar.
    index: f64,
    /// Radius that holds 95 % of the offsets that radar would not have shown by now, metres; left out where nothing bounds it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    protection_level_m: Option<f64>,
    /// Of a suspect or failed one: how far its positions are off.
    #[serde(skip_serializing_if = "Option::is_none")]
    offset: Option<OffsetJson>,
    /// What speaks against it.
    reasons: Vec<ReasonName>,
    /// Its newest report.
    heard: Rfc3339,
    /// It has fallen silent.
    silent: bool,
    /// What an operator says of it; left out where nobody has said anything.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = without(&Trust::NAMES, Trust::Automatic.name())))]
    verdict: Option<&'static str>,
    /// Of the first slot that the verdict applies to.
    #[serde(skip_serializing_if = "Option::is_none")]
    verdict_since: Option<Rfc3339>,
    /// Id of the track that radar sees where it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    twin_id: Option<String>,
    /// The last radar tracks that it was compared with, the latest first.
    #[schemars(length(max = 20))]
    evidence: Vec<EvidenceJson>,
}

/// An offset over ground.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "IntegrityOffset")]
struct OffsetJson {
    east_m: f64,
    north_m: f64,
    /// East and north, m².
    covariance_m2: [[f64; 2]; 2],
}

/// What a radar track says of a transponder.
/// How a radar track bears on what a transponder reports.
enum EvidenceKind {
    Near,
    Far,
}

fusion::interface_names!(EvidenceKind { Near = "near", Far = "far" });

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "IntegrityEvidence")]
struct EvidenceJson {
    /// Id of the radar.
    sensor: String,
    track_number: u16,
    /// Near: it was where the transponder says; far: it flies alike elsewhere.
    #[schemars(extend("enum" = EvidenceKind::NAMES))]
    kind: &'static str,
    /// The first second that counted.
    from: Rfc3339,
    /// How many seconds counted.
    seconds: u32,
    /// What it added to the index.
    gain: f64,
}

/// What an operator says.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "IntegrityVerdict")]
pub struct Body {
    /// It is what it says; it is not; or as the evidence has it.
    #[schemars(extend("enum" = Trust::NAMES))]
    verdict: String,
}

/// What is known.
pub fn all(ask: &Ask) -> Result<IntegrityList, Problem> {
    Ok(list(ask, &ask.state.hub.integrity.held()))
}

/// An operator's word.
pub fn say(ask: Ask) -> Later<IntegrityList> {
    Box::pin(async move {
        let saying = saying(&ask)?;
        if !ask.state.hub.config.judges_integrity() {
            return Err(problem(&Denied::NotJudged));
        }
        refuse_standing(&ask)?;
        let answer = ask.state.hub.integrity.ask(saying.clone()).map_err(|denied| problem(&denied))?;
        let answered = match tokio::time::timeout(PATIENCE, answer).await {
            Ok(Ok(answered)) => answered,
            Ok(Err(_)) | Err(_) => Err(Denied::Gone),
        };
        let held = answered.map_err(|denied| problem(&denied))?;
        let who = ask.state.terms().name_of(ask.pass).unwrap_or("somebody without a token").to_owned();
        let from = ask.client.map_or_else(String::new, |client| format!(" from {client}"));
        info!(
            "transponder {}: {}, by {who}{from}",
            saying.transponder.serial.escape_debug(),
            saying.trust.name()
        );
        Ok(list(&ask, &held))
    })
}

fn saying(ask: &Ask) -> Result<Saying, Problem> {
    let body: Body = serde_json::from_slice(&ask.body).map_err(|error| {
        let detail = format!("the body is JSON such as {{\"verdict\": \"distrusted\"}}: {error}");
        Problem::new(StatusCode::BAD_REQUEST, detail)
    })?;
    let trust = Trust::of_name(&body.verdict).ok_or_else(|| Problem::parameter("verdict", RULE))?;
    let country = ask.query.text("country").map(str::to_owned);
    Ok(Saying { transponder: Named { serial: ask.id.clone(), country }, trust })
}

fn list(ask: &Ask, known: &Integrities) -> IntegrityList {
    let hub = &ask.state.hub;
    let latest = ask.state.log.latest().1;
    IntegrityList {
        time: known.at.map(Rfc3339),
        computed: hub.config.judges_integrity(),
        identities: known
            .assessments
            .iter()
            .map(|assessment| IdentityJson::new(assessment, known, hub, latest.as_deref()))
            .collect(),
    }
}

impl IdentityJson {
    /// Of one of what is `known`; ids are those of the latest slot that is shown.
    pub(super) fn new(
        assessment: &Assessment,
        known: &Integrities,
        hub: &Hub,
        latest: Option<&Shown>,
    ) -> Self {
        let Assessment { identity, integrity, since, offset, heard, is_silent, twin, evidence, .. } =
            assessment;
        let tracks = || latest.into_iter().flat_map(|shown| &shown.frame.picture.tracks);
        let id = |is_it: &dyn Fn(&PictureTrack) -> bool| {
            tracks().find(|track| is_it(track)).map(|track| hub.maker.track_id(track))
        };
        let own = |track: &PictureTrack| identity_of(track) == Some(*identity);
        let word = known.word(*identity);
        let grid = SlotGrid::new(hub.config.fusion.slot);
        Self {
            identity: serial_text(*identity),
            uas_id: TransponderId::new(*identity),
            track_id: id(&own),
            state: integrity.state.into(),
            since: (*since).into(),
            index: rounded(integrity.index, 2),
            protection_level_m: integrity.protection_level_m.map(|metres| rounded(metres, 1)),
            offset: offset.as_ref().map(|(offset, covariance)| OffsetJson {
                east_m: rounded(offset.x, 1),
                north_m: rounded(offset.y, 1),
                covariance_m2: [[0, 1], [2, 3]].map(|row| row.map(|index| rounded(covariance[index], 1))),
            }),
            reasons: ReasonName::all(integrity.reasons),
            heard: (*heard).into(),
            silent: *is_silent,
            verdict: word.map(|held| held.word.trust.name()),
            verdict_since: word.map(|held| grid.centre(held.since).into()),
            twin_id: twin.and_then(|twin| id(&|track| track.point.number == twin)),
            evidence: evidence.iter().map(|evidence| EvidenceJson::new(evidence, hub)).collect(),
        }
    }
}

fn identity_of(track: &PictureTrack) -> Option<Identity> {
    track.point.source.transponder().map(|part| part.identity)
}

impl EvidenceJson {
    fn new(evidence: &Evidence, hub: &Hub) -> Self {
        let Evidence { track, is_near, from, seconds, gain } = *evidence;
        Self {
            sensor: hub.maker.sensor(track.sensor).to_owned(),
            track_number: track.number,
            kind: if is_near { EvidenceKind::Near } else { EvidenceKind::Far }.name(),
            from: from.into(),
            seconds,
            gain: rounded(gain, 2),
        }
    }
}
