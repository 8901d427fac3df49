//! OGC API – Features, part 1: core, with GeoJSON (OGC 17-069r4): the picture and the areas as collections, which geographic
//! information systems open by the address of the landing page, `/ogc`.

use axum::http::header;
use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

use super::filter::{TrackFilter, is_box};
use super::geometry::{CollectionType, Feature, GeoJsonGeometry};
use super::ground::AreaProperties;
use super::problem::Problem;
use super::query::Query;
use super::request::{ApiRequest, ApiResult, GEO_JSON, JSON, live};
use super::sensors::areas;
use super::slot_json::TrackFeature;
use fusion::time::Time;
use input::json::rounded;
use picture::Rfc3339;

/// Longitude and latitude on WGS-84, in this order.
const CRS84: &str = "http://www.opengis.net/def/crs/OGC/1.3/CRS84";
/// Half of the size of the extent around the origin, degrees of latitude: some 50 km.
const EXTENT_DEG: f64 = 0.45;
/// Number of features in an answer without `limit`.
const USUAL: usize = 1000;

/// Relations of links.
const RELATIONS: [&str; 8] =
    ["self", "service-desc", "service-doc", "conformance", "data", "items", "collection", "next"];
const HTML: &str = "text/html";
const OPENAPI: &str = "application/vnd.oai.openapi+json;version=3.1";
const FEATURE: &str = "feature";

/// A link.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Link")]
pub struct Link {
    href: String,
    #[schemars(extend("enum" = RELATIONS))]
    rel: &'static str,
    #[schemars(extend("enum" = [JSON, GEO_JSON, HTML, OPENAPI]))]
    r#type: &'static str,
}

/// `/ogc`.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "LandingPage")]
pub struct LandingPage {
    title: String,
    description: String,
    links: Vec<Link>,
}

/// Classes of requirements that the service conforms to.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "ConformanceClasses")]
pub struct ConformanceClasses {
    #[serde(rename = "conformsTo")]
    conforms_to: Vec<String>,
}

/// A collection of features.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Collection")]
pub struct Collection {
    #[schemars(extend("enum" = [TRACKS.id, AREAS.id]))]
    id: &'static str,
    title: String,
    description: String,
    extent: Extent,
    #[serde(rename = "itemType")]
    #[schemars(extend("enum" = [FEATURE]))]
    item_type: &'static str,
    crs: Vec<String>,
    links: Vec<Link>,
}

/// Where features of a collection may be.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Extent")]
pub struct Extent {
    spatial: SpatialExtent,
}

#[derive(Serialize, JsonSchema)]
#[schemars(rename = "SpatialExtent")]
pub struct SpatialExtent {
    /// West, south, east and north, degrees.
    bbox: [[f64; 4]; 1],
    #[schemars(extend("enum" = [CRS84]))]
    crs: &'static str,
}

/// `/ogc/collections`.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Collections")]
pub struct Collections {
    links: Vec<Link>,
    collections: Vec<Collection>,
}

/// Features of a collection, RFC 7946 with the members of OGC 17-069r4.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "ItemsOf{F}")]
pub struct Items<F> {
    r#type: CollectionType,
    /// Time of the picture, or of the answer if there is none.
    #[serde(rename = "timeStamp")]
    time_stamp: Rfc3339,
    #[serde(rename = "numberMatched")]
    matched: usize,
    #[serde(rename = "numberReturned")]
    returned: usize,
    links: Vec<Link>,
    features: Vec<F>,
}

/// The areas as features with ids.
pub type AreaItems = Items<AreaItem>;
/// An area with an id: its place in the list.
pub type AreaItem = Feature<'static, GeoJsonGeometry, AreaProperties>;
/// The tracks as features.
pub type TrackItems<'a> = Items<TrackFeature<'a>>;

/// A collection and what it is.
struct Described {
    id: &'static str,
    title: &'static str,
    description: &'static str,
}

const TRACKS: Described = Described {
    id: "tracks",
    title: "Air picture",
    description: "Aircraft in the latest slot, with the properties of /api/v1/tracks",
};
const AREAS: Described = Described {
    id: "areas",
    title: "Areas and zones",
    description: "Areas of the configuration, and zones of operators",
};

/// The address under which the client asks: scheme and host.
fn base(request: &ApiRequest) -> String {
    let config = &request.state.hub.config.http;
    let proxied = request.header("x-forwarded-proto").filter(|scheme| ["http", "https"].contains(scheme));
    let host = request.header(header::HOST).map_or_else(|| config.listen.to_string(), str::to_owned);
    format!("{}://{host}", proxied.unwrap_or(config.scheme()))
}

fn link(request: &ApiRequest, rel: &'static str, r#type: &'static str, path: &str) -> Link {
    Link { href: format!("{}{path}", base(request)), rel, r#type }
}

/// `/ogc`: where everything else is.
pub fn landing(request: &ApiRequest) -> Result<LandingPage, Problem> {
    let to = |rel, kind, path| link(request, rel, kind, path);
    Ok(LandingPage {
        title: format!("utm-fusion {}", request.state.hub.config.site.name),
        description: "One air picture of drone traffic".to_owned(),
        links: vec![
            to("self", JSON, "/ogc"),
            to("service-desc", OPENAPI, "/openapi.json"),
            to("service-doc", HTML, "/api/docs"),
            to("conformance", JSON, "/ogc/conformance"),
            to("data", JSON, "/ogc/collections"),
        ],
    })
}

/// `/ogc/conformance`.
pub fn conformance(_: &ApiRequest) -> Result<ConformanceClasses, Problem> {
    Ok(ConformanceClasses {
        conforms_to: ["core", "geojson"]
            .map(|class| format!("http://www.opengis.net/spec/ogcapi-features-1/1.0/conf/{class}"))
            .into(),
    })
}

/// `/ogc/collections`.
pub fn collections(request: &ApiRequest) -> Result<Collections, Problem> {
    Ok(Collections {
        links: vec![link(request, "self", JSON, "/ogc/collections")],
        collections: [TRACKS, AREAS].map(|of| collection(request, &of)).into(),
    })
}

/// `/ogc/collections/tracks`.
pub fn tracks_collection(request: &ApiRequest) -> Result<Collection, Problem> {
    Ok(collection(request, &TRACKS))
}

/// `/ogc/collections/areas`.
pub fn areas_collection(request: &ApiRequest) -> Result<Collection, Problem> {
    Ok(collection(request, &AREAS))
}

fn collection(request: &ApiRequest, of: &Described) -> Collection {
    let (latitude_deg, longitude_deg, _) = request.state.hub.config.origin();
    let east_deg = EXTENT_DEG / latitude_deg.to_radians().cos().max(0.01);
    let bbox = [
        (longitude_deg - east_deg).max(-180.0),
        (latitude_deg - EXTENT_DEG).max(-90.0),
        (longitude_deg + east_deg).min(180.0),
        (latitude_deg + EXTENT_DEG).min(90.0),
    ]
    .map(|degrees| rounded(degrees, 4));
    let path = format!("/ogc/collections/{}", of.id);
    Collection {
        id: of.id,
        title: of.title.to_owned(),
        description: of.description.to_owned(),
        extent: Extent { spatial: SpatialExtent { bbox: [bbox], crs: CRS84 } },
        item_type: FEATURE,
        crs: vec![CRS84.to_owned()],
        links: vec![
            link(request, "self", JSON, &path),
            link(request, "items", GEO_JSON, &format!("{path}/items")),
        ],
    }
}

/// The bounding box of a request: four numbers, or six with heights, which are not compared.
fn bbox(query: &Query) -> Result<Option<[f64; 4]>, Problem> {
    const RULE: &str = "lon_min,lat_min,lon_max,lat_max, degrees; or with heights lon_min,lat_min,h_min,lon_max,lat_max,h_max";
    let Some(text) = query.text("bbox") else { return Ok(None) };
    let bbox = match text.split(',').count() {
        6 => query
            .numbers::<6>("bbox", RULE)?
            .map(|[west, south, _, east, north, _]| [west, south, east, north]),
        _ => query.numbers::<4>("bbox", RULE)?,
    };
    bbox.filter(|bbox| is_box(*bbox)).map(Some).ok_or_else(|| Problem::parameter("bbox", RULE))
}

/// Whether a time is within `datetime`: an instant, or an interval with `..` for an open end.
fn is_wanted(query: &Query, time: Time) -> Result<bool, Problem> {
    const RULE: &str = "a time of RFC 3339, or an interval start/end, of which one may be ..";
    let Some(text) = query.text("datetime") else { return Ok(true) };
    let instant = |text: &str| -> Option<Option<Time>> {
        if text.is_empty() || text == ".." {
            return Some(None);
        }
        let stamp: jiff::Timestamp = text.parse().ok()?;
        i64::try_from(stamp.as_nanosecond()).ok().map(Time::from_nanos).map(Some)
    };
    let parsed = match text.split_once('/') {
        Some((start, end)) => instant(start).zip(instant(end)).filter(|ends| *ends != (None, None)),
        None => instant(text).filter(Option::is_some).map(|at| (at, at)),
    };
    let (start, end) = parsed.ok_or_else(|| Problem::parameter("datetime", RULE))?;
    if start.zip(end).is_some_and(|(start, end)| start > end) {
        return Err(Problem::parameter("datetime", RULE));
    }
    Ok(start.is_none_or(|start| start <= time) && end.is_none_or(|end| time <= end))
}

/// Number of features at most.
fn limit(query: &Query) -> Result<usize, Problem> {
    let limit = query.value("limit", "a whole number, 1 to 10000", |limit| (1..=10_000).contains(limit))?;
    Ok(limit.unwrap_or(USUAL))
}

/// The query of this request, or with another start of the page.
fn query_text(request: &ApiRequest, after: Option<&str>) -> String {
    let mut query = form_urlencoded::Serializer::new(String::new());
    for name in request.query.names().filter(|name| after.is_none() || *name != "after") {
        query.append_pair(name, request.query.text(name).unwrap_or_default());
    }
    query.extend_pairs(after.map(|after| ("after", after))).finish()
}

/// An answer with features that are JSON already.
fn items(
    request: &ApiRequest,
    of: &Described,
    (time, matched, next): (Time, usize, Option<&str>),
    features: impl ExactSizeIterator<Item = impl AsRef<[u8]>>,
) -> ApiResult {
    let path = format!("/ogc/collections/{}/items", of.id);
    let asked = query_text(request, None);
    let asked = if asked.is_empty() { path.clone() } else { format!("{path}?{asked}") };
    let mut links = vec![
        link(request, "self", GEO_JSON, &asked),
        link(request, "collection", JSON, &format!("/ogc/collections/{}", of.id)),
    ];
    links.extend(next.map(|after| {
        link(request, "next", GEO_JSON, &format!("{path}?{}", query_text(request, Some(after))))
    }));
    let head = Items::<()> {
        r#type: CollectionType::default(),
        time_stamp: time.into(),
        matched,
        returned: features.len(),
        links,
        features: Vec::new(),
    };
    let mut out = serde_json::to_vec(&head).unwrap_or_default();
    // The features are last, and empty so far.
    out.truncate(out.len().saturating_sub(2));
    for (index, feature) in features.enumerate() {
        if index > 0 {
            out.push(b',');
        }
        out.extend_from_slice(feature.as_ref());
    }
    out.extend_from_slice(b"]}");
    Ok(live(GEO_JSON, out))
}

/// `/ogc/collections/tracks/items`: tracks of the latest slot.
pub fn tracks(request: &ApiRequest) -> ApiResult {
    let (query, limit) = (&request.query, limit(&request.query)?);
    let mut selection = form_urlencoded::Serializer::new(String::new());
    selection.append_pair("limit", &limit.to_string());
    if let Some(bbox) = bbox(query)? {
        selection.append_pair("bbox", &bbox.map(|degrees| degrees.to_string()).join(","));
    }
    if let Some(after) = query.text("after") {
        selection.append_pair("after", after);
    }
    let filter = TrackFilter::of(&Query::parse(&selection.finish())?, &request.state.hub.config.sensors)?;
    let (_, latest) = request.state.log.latest();
    let time = latest.as_ref().map_or_else(|| request.state.now(), |slot| slot.time());
    let is_wanted = is_wanted(query, time)?;
    let slot = latest.filter(|_| is_wanted);
    let page = slot.as_ref().map(|slot| filter.page(slot.all(), |(_, slice)| slice));
    let Some(page) = page else {
        return items(request, &TRACKS, (time, 0, None), std::iter::empty::<&[u8]>());
    };
    let features: Vec<_> = page.tracks.iter().map(|(slot, slice)| slot.feature(slice, false)).collect();
    items(request, &TRACKS, (time, page.matched, page.next.as_deref()), features.into_iter())
}

/// `/ogc/collections/areas/items`: the areas, with their places in the list as ids.
pub fn area_items(request: &ApiRequest) -> ApiResult {
    let (query, limit) = (&request.query, limit(&request.query)?);
    let after =
        query.value("after", "next of the page before, a whole number", |_: &usize| true)?.unwrap_or(0);
    let bbox = bbox(query)?;
    let is_wanted = is_wanted(query, request.state.now())?;
    let all = area_features(request)?.into_iter().filter(|area| {
        is_wanted
            && bbox.is_none_or(|bbox| {
                bounds(&area["geometry"]["coordinates"]).is_none_or(|of| overlap(bbox, of))
            })
    });
    let matching: Vec<Value> = all.collect();
    let page: Vec<String> = matching.iter().skip(after).take(limit).map(Value::to_string).collect();
    let end = after.saturating_add(page.len());
    let next = (end < matching.len()).then(|| end.to_string());
    items(request, &AREAS, (request.state.now(), matching.len(), next.as_deref()), page.into_iter())
}

/// `/ogc/collections/areas/items/{id}`.
pub fn area(request: &ApiRequest) -> ApiResult {
    let found = area_features(request)?.into_iter().find(|area| area["id"] == *request.id);
    let area = found.ok_or_else(|| Problem::not_found("no area has this id"))?;
    Ok(live(GEO_JSON, area.to_string()))
}

/// The areas as features with ids.
fn area_features(request: &ApiRequest) -> Result<Vec<Value>, Problem> {
    let areas = serde_json::to_value(areas(request)?).unwrap_or_default();
    let features = areas["features"].as_array().cloned().unwrap_or_default();
    let with_id = |(index, feature): (usize, Value)| {
        let mut named = Map::new();
        named.insert("type".to_owned(), feature["type"].clone());
        named.insert("id".to_owned(), index.to_string().into());
        for key in ["geometry", "properties"] {
            named.insert(key.to_owned(), feature[key].clone());
        }
        Value::Object(named)
    };
    Ok(features.into_iter().enumerate().map(with_id).collect())
}

/// West, south, east and north of coordinates of any depth; `None` without any.
fn bounds(coordinates: &Value) -> Option<[f64; 4]> {
    let list = coordinates.as_array()?;
    if let [longitude, latitude, ..] = list.as_slice()
        && let Some((longitude, latitude)) = longitude.as_f64().zip(latitude.as_f64())
    {
        return Some([longitude, latitude, longitude, latitude]);
    }
    list.iter()
        .filter_map(bounds)
        .reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])])
}

/// Whether two boxes overlap; a box whose west is east of its east spans the antimeridian.
fn overlap(wanted: [f64; 4], of: [f64; 4]) -> bool {
    let [west, south, east, north] = wanted;
    let in_longitude =
        if west <= east { of[0] <= east && west <= of[2] } else { of[0] <= east || west <= of[2] };
    in_longitude && of[1] <= north && south <= of[3]
}
