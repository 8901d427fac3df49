//! `/api/v1/integrity`: integrity of transponders, and operator verdicts on them.

use std::time::Duration;

use axum::http::StatusCode;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use tracing::info;

use super::correlations::{problem, refuse_standing};
use super::problem::Problem;
use super::request::{AnswerFuture, ApiRequest};
use super::slot_json::SlotJson;
use fusion::Identity;
use fusion::integrity::{Assessment, Evidence, Trust};
use fusion::slots::SlotGrid;
use input::json::rounded;
use input::names::without;
use picture::{PictureTrack, ReasonName, Rfc3339, StateName, TransponderId, serial_text};
use service::live::{Hub, RequestError, TransponderName, TrustAssessments, TrustRequest};

/// Timeout for the engine, which takes verdicts several times per second.
const ENGINE_TIMEOUT: Duration = Duration::from_secs(2);

const RULE: &str = "a verdict is trusted, distrusted or automatic";

/// Integrity of the transponders heard in the last hour.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Integrity")]
pub struct IntegrityList {
    /// Time of the slot to which the states apply.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
    /// Whether integrity is evaluated. It is not in the reference profile, nor with `[integrity] action = "off"`.
    computed: bool,
    identities: Vec<IdentityJson>,
}

/// Integrity of a transponder.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "IdentityIntegrity")]
pub struct IdentityJson {
    /// Serial number, as used in the path.
    identity: String,
    uas_id: TransponderId,
    /// Id of its track, if it has one in the latest slot.
    #[serde(skip_serializing_if = "Option::is_none")]
    track_id: Option<String>,
    state: StateName,
    /// Time since which the state applies.
    since: Rfc3339,
    /// Natural logarithm of the likelihood ratio of a false to a true report, by radar.
    index: f64,
    /// Protection level, in metres: radius that contains 95 % of the position offsets that radar would not have revealed so far.
    /// Left out if there is no bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    protection_level_m: Option<f64>,
    /// Estimated offset of its positions; only for a suspect or failed transponder.
    #[serde(skip_serializing_if = "Option::is_none")]
    offset: Option<OffsetJson>,
    /// Evidence against the transponder.
    reasons: Vec<ReasonName>,
    /// Time of its newest report.
    heard: Rfc3339,
    /// Whether the transponder has fallen silent.
    silent: bool,
    /// Operator verdict; left out if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("enum" = without(&Trust::NAMES, Trust::Automatic.name())))]
    verdict: Option<&'static str>,
    /// Time of the first slot to which the verdict applies.
    #[serde(skip_serializing_if = "Option::is_none")]
    verdict_since: Option<Rfc3339>,
    /// Id of the track that radar sees at another position than the reported one.
    #[serde(skip_serializing_if = "Option::is_none")]
    twin_id: Option<String>,
    /// Radar tracks with which the transponder was compared, latest first.
    #[schemars(length(max = 20))]
    evidence: Vec<EvidenceJson>,
}

/// Horizontal offset.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "IntegrityOffset")]
struct OffsetJson {
    east_m: f64,
    north_m: f64,
    /// Covariance of east and north, in m².
    covariance_m2: [[f64; 2]; 2],
}

/// Kind of evidence that a radar track gives about a transponder.
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
    /// `near`: the radar track was at the reported position. `far`: it flies the same way elsewhere.
    #[schemars(extend("enum" = EvidenceKind::NAMES))]
    kind: &'static str,
    /// First second that counted.
    from: Rfc3339,
    /// Number of seconds that counted.
    seconds: u32,
    /// Contribution to the index.
    gain: f64,
}

/// Operator verdict on a transponder.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "IntegrityVerdict")]
pub struct VerdictBody {
    /// Whether the transponder is to be trusted, not to be trusted, or to be judged by the evidence.
    #[schemars(extend("enum" = Trust::NAMES))]
    verdict: String,
}

/// Current integrity of all transponders.
pub fn all(request: &ApiRequest) -> Result<IntegrityList, Problem> {
    Ok(list(request, &request.state.hub.trust_requests.in_force()))
}

/// Records an operator verdict.
pub fn set_verdict(request: ApiRequest) -> AnswerFuture<IntegrityList> {
    Box::pin(async move {
        let saying = parse_verdict(&request)?;
        if !request.state.hub.config.evaluates_integrity() {
            return Err(problem(&RequestError::NotJudged));
        }
        refuse_standing(&request)?;
        let answer =
            request.state.hub.trust_requests.submit(saying.clone()).map_err(|denied| problem(&denied))?;
        let answered = match tokio::time::timeout(ENGINE_TIMEOUT, answer).await {
            Ok(Ok(answered)) => answered,
            Ok(Err(_)) | Err(_) => Err(RequestError::Gone),
        };
        let held = answered.map_err(|denied| problem(&denied))?;
        let who = request
            .state
            .access()
            .token_name(request.credential)
            .unwrap_or("somebody without a token")
            .to_owned();
        let from = request.client.map_or_else(String::new, |client| format!(" from {client}"));
        info!(
            "transponder {}: {}, by {who}{from}",
            saying.transponder.serial.escape_debug(),
            saying.trust.name()
        );
        Ok(list(&request, &held))
    })
}

fn parse_verdict(request: &ApiRequest) -> Result<TrustRequest, Problem> {
    let body: VerdictBody = serde_json::from_slice(&request.body).map_err(|error| {
        let detail = format!("the body is JSON such as {{\"verdict\": \"distrusted\"}}: {error}");
        Problem::new(StatusCode::BAD_REQUEST, detail)
    })?;
    let trust = Trust::of_name(&body.verdict).ok_or_else(|| Problem::parameter("verdict", RULE))?;
    let country = request.query.text("country").map(str::to_owned);
    Ok(TrustRequest { transponder: TransponderName { serial: request.id.clone(), country }, trust })
}

fn list(request: &ApiRequest, known: &TrustAssessments) -> IntegrityList {
    let hub = &request.state.hub;
    let latest = request.state.log.latest().1;
    IntegrityList {
        time: known.at.map(Rfc3339),
        computed: hub.config.evaluates_integrity(),
        identities: known
            .assessments
            .iter()
            .map(|assessment| IdentityJson::new(assessment, known, hub, latest.as_deref()))
            .collect(),
    }
}

impl IdentityJson {
    /// Integrity of one transponder of `known`. Track ids are those of the latest slot.
    pub(super) fn new(
        assessment: &Assessment,
        known: &TrustAssessments,
        hub: &Hub,
        latest: Option<&SlotJson>,
    ) -> Self {
        let Assessment { identity, integrity, since, offset, heard, is_silent, twin, evidence, .. } =
            assessment;
        let tracks = || latest.into_iter().flat_map(|slot| &slot.frame.picture.tracks);
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
