import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import utm_fusion
from conftest import ctrl_c, damaged
from utm_fusion import Error, InputWarning


@pytest.fixture(scope="module")
def tables(flight, program, tmp_path_factory):
    out = tmp_path_factory.mktemp("tables")
    program("decode", flight["capture"], "--format", "parquet", "-o", out)
    return out


@pytest.mark.parametrize("cat", [21, 34, 48, 129])
def test_columns_are_those_of_decode(flight, tables, cat):
    expected = pq.read_table(tables / f"cat{cat:03}.parquet")
    table = utm_fusion.table(flight["capture"], cat)
    assert len(table) == expected.num_rows > 10 and table.columns == expected.column_names
    # The Parquet reader keeps the name of the time zone as written.
    assert pa.table(table).cast(expected.schema).equals(expected)
    assert table.unread is None and table.faults == {} and table.damage is None


def test_arrow_takes_it_in_one_call(flight):
    table = utm_fusion.table(flight["capture"], 48)
    schema = pa.schema(table)
    assert pa.table(table).schema == schema
    assert schema.field("time").type == pa.timestamp("us", "UTC")
    assert schema.field("I048_040_rho_m").type == pa.float64() and schema.field("sac").type == pa.int64()
    assert pa.table(table).equals(pa.table(table)), "it is not used up"
    assert repr(table) == f"<utm_fusion.Table of {len(table)} rows, {len(table.columns)} columns>"


def test_pandas_and_polars_take_it(flight):
    plots = utm_fusion.plots(flight["capture"])
    pandas = pytest.importorskip("pandas")
    frame = plots.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and len(frame) == len(plots) and frame["range_m"].min() > 0
    polars = pytest.importorskip("polars")
    assert polars.DataFrame(plots)["range_m"].to_list() == frame["range_m"].to_list()


def test_some_columns_are_those_of_all(flight):
    names = ["I048_161_track_number", "time", "I048_040_rho_m"]
    some = pa.table(utm_fusion.table(flight["capture"], 48, columns=names))
    assert some.equals(pa.table(utm_fusion.table(flight["capture"], 48)).select(names))
    with pytest.raises(Error, match='cat048 has no column "I048_999"'):
        utm_fusion.table(flight["capture"], 48, columns=["I048_999"])


def test_plots_are_the_records(flight):
    plots = pa.table(utm_fusion.plots(flight["capture"])).to_pylist()
    records = list(utm_fusion.records(flight["capture"], cat=48))
    assert len(plots) == len(records)
    for plot, record in zip(plots, records):
        items = record["items"]
        assert plot["range_m"] == items["040"]["rho_m"] and plot["azimuth_deg"] == items["040"]["theta_deg"]
        assert plot["sic"] == record["sic"] and plot["time_of_day_s"] == items["140"]
        assert plot["track_number"] == items["161"]["track_number"] and plot["type"] == items["020"]["typ"]
        assert plot["time"].isoformat()[:19] == record["time"][:19]


def test_a_category_that_is_not_there_has_no_rows(flight):
    table = utm_fusion.table(flight["capture"], 62)
    assert len(table) == 0 and "I062_040" in table.columns
    assert pa.table(table).num_rows == 0
    with pytest.raises(Error, match="category 200 has no public definition"):
        utm_fusion.table(flight["capture"], 200)


def test_what_cannot_be_read_is_told(flight, tmp_path):
    octets = damaged(flight["radar"])
    with pytest.warns(InputWarning, match="errors in the input"):
        table = utm_fusion.table(octets, 48)
    with pytest.warns(InputWarning):
        records = list(utm_fusion.records(octets, cat=48))
    errors = [record["error"] for record in records if "error" in record]
    unread = pa.table(table.unread).to_pylist()
    assert [row["kind"] for row in unread if row["kind"] != "block"] == [error["kind"] for error in errors]
    assert sum(table.faults.values()) == len(errors) > 15
    assert len(table) == sum("items" in record for record in records)


def test_a_capture_that_breaks_off_keeps_what_was_before(flight):
    whole = utm_fusion.table(flight["capture"], 48)
    with pytest.warns(InputWarning, match="bytes: "):
        cut = utm_fusion.table(flight["capture"].read_bytes()[:-20], 48)
    assert cut.damage.startswith("bytes: ")
    assert len(whole) - 20 <= len(cut) <= len(whole)
    assert pa.table(cut).equals(pa.table(whole).slice(0, len(cut)))


def test_a_table_of_many_rows_is_whole(flight):
    octets = flight["radar"].read_bytes()
    once = pa.table(utm_fusion.table(octets, 48, columns=["I048_040_rho_m"]))
    times = 70_000 // once.num_rows + 1
    many = pa.table(utm_fusion.table(octets * times, 48, columns=["I048_040_rho_m"]))
    assert many.column(0).num_chunks == 2
    assert many.column(0).to_pylist() == once.column(0).to_pylist() * times


def test_ctrl_c_ends_a_table(flight, tmp_path):
    path = tmp_path / "long.ast"
    path.write_bytes(flight["radar"].read_bytes() * 400)
    with ctrl_c(0.1):
        while True:
            utm_fusion.table(path, 48)
