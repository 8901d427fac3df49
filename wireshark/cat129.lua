-- ASTERIX category 129 (UAS identification reports, edition 1.2) for Wireshark 4.0 and later. README.md says how to use it.
--
-- Blocks of other categories go to Wireshark's own ASTERIX dissector. What is wrong has the names and the place that
-- `utm-fusion decode` gives it (`asterix/src/fault.rs`).

-- items: made of asterix/src/cat129 by tests/readers/wireshark/generate.rs; UPDATE=1 makes them anew.
local ITEMS = {
    [1] = { number = "010", title = "Data Source Identifier", is = "fields", parts = {
        { key = "sac", title = "System Area Code", bits = 8, is = "count" },
        { key = "sic", title = "System Identification Code", bits = 8, is = "count" },
    } },
    [2] = { number = "015", title = "Data Destination Identifier", is = "fields", parts = {
        { key = "dac", title = "Destination Area Code", bits = 8, is = "count" },
        { key = "dic", title = "Destination Identification Code", bits = 8, is = "count" },
    } },
    [3] = { number = "020", title = "UAS Manufacturer Identification", is = "value", parts = {
        { key = "", title = "", bits = 24, is = "text" },
    } },
    [4] = { number = "030", title = "UAS Model Identification", is = "value", parts = {
        { key = "", title = "", bits = 24, is = "text" },
    } },
    [5] = { number = "040", title = "UAS Serial Number", is = "value", parts = {
        { key = "", title = "", bits = 96, is = "text" },
    } },
    [6] = { number = "050", title = "UAS Registration Country", is = "value", parts = {
        { key = "", title = "", bits = 16, is = "text" },
    } },
    [7] = { number = "070", title = "Time of Day", is = "value", parts = {
        { key = "", title = "", bits = 24, is = "quantity", lsb = 1/2^7, decimals = 7, unit = " s", clock = true },
    } },
    [8] = { number = "080", title = "Position in WGS-84 Co-ordinates", is = "fields", parts = {
        { key = "latitude_deg", title = "Latitude", bits = 32, is = "quantity", lsb = 180/2^30, decimals = 8, unit = "°", signed = true },
        { key = "longitude_deg", title = "Longitude", bits = 32, is = "quantity", lsb = 180/2^30, decimals = 8, unit = "°", signed = true },
    } },
    [9] = { number = "090", title = "Altitude above Mean Sea Level", is = "fields", parts = {
        { key = "altitude_m", title = "Altitude", bits = 24, is = "quantity", lsb = 1/10, decimals = 1, unit = " m", signed = true },
    } },
    [10] = { number = "100", title = "Altitude above Ground Level", is = "fields", parts = {
        { key = "altitude_m", title = "Altitude", bits = 24, is = "quantity", lsb = 1/10, decimals = 1, unit = " m", signed = true },
    } },
    [11] = { number = "110", title = "GNSS Signal Accuracy", is = "fields", parts = {
        { key = "accuracy_m", title = "Accuracy", bits = 16, is = "quantity", lsb = 1, decimals = 0, unit = " m", unknown = 0 },
    } },
    [12] = { number = "120", title = "Operational Risk", is = "one_or_three", parts = {
        { key = "certification_category", title = "Certification category", bits = 2, is = "count", codes = { [0] = "Unknown", [1] = "Open", [2] = "Specific", [3] = "Certified" } },
        { key = "air_risk_category", title = "Air risk category", bits = 2, is = "count", first = 1 },
        { key = "airspace_encounter_category", title = "Airspace encounter category", bits = 4, is = "count" },
    } },
    [13] = { number = "SP", title = "Special Purpose Field", is = "explicit", known_title = "of the fusion service", parts = {
    }, forms = {
        { known = "uf", parts = {
            { key = "magic", title = "Magic", bits = 24, is = "constant", value = 5588481 },
            { key = "source", title = "Source", bits = 8, is = "count", codes = { [1] = "Fused", [2] = "Radar", [3] = "Transponder", [4] = "Camera" } },
            { key = "track_number", title = "Track number", bits = 32, is = "count" },
            { key = "radar_track", title = "Radar track", bits = 16, is = "count", unknown = 65535 },
            { key = "transponder", title = "Transponder", bits = 32, is = "count", unknown = 4294967295 },
            { key = "horizontal_deviation_m", title = "Horizontal deviation", bits = 16, is = "quantity", lsb = 1/10, decimals = 1, unit = " m", unknown = 65535 },
            { key = "vertical_deviation_m", title = "Vertical deviation", bits = 16, is = "quantity", lsb = 1/10, decimals = 1, unit = " m", unknown = 65535 },
            { key = "spare", title = "Spare", bits = 2, is = "spare" },
            { key = "height_not_measured", title = "Height not measured", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "uncooperative", title = "Uncooperative", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "integrity_failed", title = "Integrity failed", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "integrity_suspect", title = "Integrity suspect", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "extrapolated", title = "Extrapolated", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "interpolated", title = "Interpolated", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "uav_probability", title = "UAV probability", bits = 8, is = "quantity", lsb = 1/254, decimals = 3, unit = "", unknown = 255 },
            { key = "spare_2", title = "Spare 2", bits = 8, is = "spare" },
        } },
        { known = "uf", parts = {
            { key = "magic", title = "Magic", bits = 24, is = "constant", value = 5588482 },
            { key = "source", title = "Source", bits = 8, is = "count", codes = { [1] = "Fused", [2] = "Radar", [3] = "Transponder", [4] = "Camera" } },
            { key = "track_number", title = "Track number", bits = 32, is = "count" },
            { key = "radar_track", title = "Radar track", bits = 16, is = "count", unknown = 65535 },
            { key = "transponder", title = "Transponder", bits = 32, is = "count", unknown = 4294967295 },
            { key = "horizontal_deviation_m", title = "Horizontal deviation", bits = 16, is = "quantity", lsb = 1/10, decimals = 1, unit = " m", unknown = 65535 },
            { key = "vertical_deviation_m", title = "Vertical deviation", bits = 16, is = "quantity", lsb = 1/10, decimals = 1, unit = " m", unknown = 65535 },
            { key = "spare", title = "Spare", bits = 2, is = "spare" },
            { key = "height_not_measured", title = "Height not measured", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "uncooperative", title = "Uncooperative", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "integrity_failed", title = "Integrity failed", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "integrity_suspect", title = "Integrity suspect", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "extrapolated", title = "Extrapolated", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "interpolated", title = "Interpolated", bits = 1, is = "count", codes = { [0] = "no", [1] = "yes" } },
            { key = "uav_probability", title = "UAV probability", bits = 8, is = "quantity", lsb = 1/254, decimals = 3, unit = "", unknown = 255 },
            { key = "spare_2", title = "Spare 2", bits = 8, is = "spare" },
            { key = "serial_number", title = "Serial number", bits = 160, is = "text" },
        } },
        { known = "uf", parts = {
            { key = "magic", title = "Magic", bits = 24, is = "constant", value = 5588483 },
            { key = "serial_number", title = "Serial number", bits = 160, is = "text" },
        } },
    } },
    [14] = { number = "185", title = "Horizontal Velocity", is = "fields", parts = {
        { key = "east_m_s", title = "East", bits = 20, is = "quantity", lsb = 1/100, decimals = 2, unit = " m/s", signed = true },
        { key = "north_m_s", title = "North", bits = 20, is = "quantity", lsb = 1/100, decimals = 2, unit = " m/s", signed = true },
    } },
    [15] = { number = "220", title = "Vertical Velocity", is = "fields", parts = {
        { key = "spare", title = "Spare", bits = 4, is = "spare" },
        { key = "up_m_s", title = "Up", bits = 20, is = "quantity", lsb = 1/100, decimals = 2, unit = " m/s", signed = true },
    } },
}
-- end of items

local CATEGORY = 129
local HEADER = 3    -- octets of CAT and LEN
local MOST_FSPEC = 8    -- octets of the longest FSPEC that is read

local cat129 = Proto("cat129", "ASTERIX Category 129, UAS Identification Reports")

-- The fields that can be filtered by: those of every block, then those of the items, `cat129.080.latitude_deg`.

local framing = {
    block = ProtoField.none("cat129.block", "Block"),
    category = ProtoField.uint8("cat129.cat", "Category"),
    length = ProtoField.uint16("cat129.len", "Length"),
    record = ProtoField.none("cat129.record", "Record"),
    fspec = ProtoField.bytes("cat129.fspec", "Field Specification"),
}
local fields = {}
for _, field in pairs(framing) do
    table.insert(fields, field)
end

local function whole_number(name, title, part)
    if part.bits > 16 then
        return ProtoField.uint32(name, title, base.DEC, part.codes)
    elseif part.bits > 8 then
        return ProtoField.uint16(name, title, base.DEC, part.codes)
    elseif part.bits < 8 and not part.first then
        -- The bits themselves are shown beside the value.
        return ProtoField.uint8(name, title, base.DEC, part.codes, (2 ^ part.bits - 1) * 2 ^ (8 - part.at % 8 - part.bits))
    end
    return ProtoField.uint8(name, title, base.DEC, part.codes)
end

local MAKE = {
    text = function(name, title) return ProtoField.string(name, title) end,
    quantity = function(name, title) return ProtoField.double(name, title) end,
    spare = whole_number,
    count = whole_number,
}

-- Fields by their names: forms of an item share them.
local made = {}

-- Gives each part of an item its bit in the item and, unless it is always the same, its field.
local function prepare(prefix, parts)
    local at = 0
    for _, part in ipairs(parts) do
        part.at = at
        at = at + part.bits
        local make = MAKE[part.is]
        if make then
            local name = part.key == "" and prefix or prefix .. "." .. part.key
            if not made[name] then
                made[name] = make(name, part.title, part)
                table.insert(fields, made[name])
            end
            part.field = made[name]
        end
    end
    return at / 8
end

for _, item in pairs(ITEMS) do
    item.name = "I129/" .. item.number .. " " .. item.title
    local prefix = "cat129." .. item.number:lower()
    if item.is == "value" then
        -- An item of one value has no node of its own.
        item.parts[1].title = item.name
    else
        item.field = ProtoField.none(prefix, item.name)
        table.insert(fields, item.field)
    end
    if item.is == "explicit" then
        item.opaque = ProtoField.bytes(prefix .. ".octets", "Octets")
        table.insert(fields, item.opaque)
        for _, form in ipairs(item.forms) do
            form.octets = prepare(prefix .. "." .. form.known, form.parts)
        end
    elseif item.is == "one_or_three" then
        item.undescribed = ProtoField.bytes(prefix .. ".undescribed", "Undescribed")
        table.insert(fields, item.undescribed)
    end
    item.octets = prepare(prefix, item.parts)
end
cat129.fields = fields

local function expert_info(name, text, group, severity)
    return ProtoExpert.new("cat129." .. name, text, group, severity)
end

local faults = {}
for name, text in pairs({
    block_too_short = "The block's LEN is below 3, the size of its own header",
    block_past_end = "The block is cut off: LEN passes the end of the datagram",
    fspec_past_end = "The FSPEC is cut off by the end of its block",
    fspec_too_long = "The FSPEC is longer than any record needs",
    reserved_frn = "The FSPEC announces an item that the category does not define: the rest of the block cannot be read",
    item_past_end = "The item is cut off by the end of its block",
    length_zero = "The length octet is 0, although it counts itself",
}) do
    faults[name] = expert_info(name, text, expert.group.MALFORMED, expert.severity.ERROR)
end
local spare_set = expert_info("spare_set", "Spare bits are set", expert.group.PROTOCOL, expert.severity.NOTE)
local several = expert_info(
    "several_records", "The block holds several records; edition 1.2 allows one", expert.group.PROTOCOL, expert.severity.WARN)
local time_past_day = expert_info(
    "time_past_day", "The time of day is past the end of the day", expert.group.PROTOCOL, expert.severity.WARN)
faults.not_captured = expert_info(
    "not_captured", "The capture has only the beginning of this datagram", expert.group.PROTOCOL, expert.severity.WARN)
local experts = { spare_set, several, time_past_day }
for _, fault in pairs(faults) do
    table.insert(experts, fault)
end
cat129.experts = experts

-- Values.

local function count_of(tvb, at, part)
    return tvb(at, math.ceil((part.at % 8 + part.bits) / 8)):bitfield(part.at % 8, part.bits)
end

-- To so many decimals, halves away from zero, as `decode` rounds.
local function rounded(value, decimals)
    local scale = 10 ^ decimals
    local size = math.floor(math.abs(value) * scale + 0.5) / scale
    return (value < 0 and size > 0) and -size or size
end

-- Without zeros at the end.
local function decimal(value, decimals)
    local text = string.format("%." .. decimals .. "f", value)
    return decimals > 0 and (text:gsub("0+$", ""):gsub("%.$", "")) or text
end

local function clock(seconds)
    local whole = math.floor(seconds)
    local fraction = decimal(seconds - whole, 7):sub(2)
    return string.format("%02d:%02d:%02d%s UTC", math.floor(whole / 3600), math.floor(whole / 60) % 60, whole % 60, fraction)
end

-- Shows a part of the item that begins at octet `start`; gives what it says, as text.
local function show(tvb, start, part, tree)
    local first = start + math.floor(part.at / 8)
    local range = tvb(first, math.ceil((part.at % 8 + part.bits) / 8))
    if part.is == "text" then
        local text = range:raw()
        -- Whatever is no printable ASCII as hexadecimal: the octets may be no text at all.
        text = text:gsub("[^ -~]", function(octet) return string.format("\\x%02x", octet:byte()) end)
        tree:add(part.field, range, text)
        return text
    end
    local count = count_of(tvb, first, part)
    if part.is == "constant" then
        return nil
    elseif part.is == "spare" then
        if count ~= 0 then
            tree:add(part.field, range):add_proto_expert_info(spare_set)
        end
        return nil
    elseif count == part.unknown then
        tree:add(range, part.title .. ": unknown or none")
        return nil
    elseif part.is == "quantity" then
        if part.signed and count >= 2 ^ (part.bits - 1) then
            count = count - 2 ^ part.bits
        end
        local value = rounded(count * part.lsb, part.decimals)
        local text = decimal(value, part.decimals) .. part.unit
        if part.clock then
            text = clock(value) .. " (" .. text .. ")"
        end
        local shown = tree:add(part.field, range, value, part.title .. ": " .. text)
        if part.clock and value >= 86400 then
            shown:add_proto_expert_info(time_past_day)
        end
        return text
    elseif part.first then
        tree:add(part.field, range, count + part.first)
        return tostring(count + part.first)
    end
    tree:add(part.field, range)
    return part.codes and part.codes[count] or tostring(count)
end

local function show_parts(tvb, start, parts, tree)
    local said = {}
    for _, part in ipairs(parts) do
        local text = show(tvb, start, part, tree)
        if text then
            said[part.key] = text
        end
    end
    return said
end

-- Items: how long each is, and what it says.

-- Octets of the item that begins at `at`; or nil and the fault, where it does not end before `stop`.
local function measure(tvb, item, at, stop, long)
    local octets = item.octets
    if item.is == "explicit" then
        if at == stop then
            return nil, "item_past_end"
        end
        octets = tvb(at, 1):uint()
        if octets == 0 then
            return nil, "length_zero"
        end
    elseif item.is == "one_or_three" and long then
        octets = 3
    end
    if at + octets > stop then
        return nil, "item_past_end"
    end
    return octets
end

-- Whether an explicit item is laid out as the parts of a form say: as long, and with each constant.
local function has_form(tvb, form, at, octets)
    if octets ~= 1 + form.octets then
        return false
    end
    for _, part in ipairs(form.parts) do
        if part.is == "constant" and count_of(tvb, at + 1 + part.at / 8, part) ~= part.value then
            return false
        end
    end
    return true
end

-- The form of an explicit item, if it has one.
local function form_of(tvb, item, at, octets)
    for _, form in ipairs(item.forms) do
        if has_form(tvb, form, at, octets) then
            return form
        end
    end
end

local function show_item(tvb, item, at, octets, tree)
    if item.is == "value" then
        return { [""] = show(tvb, at, item.parts[1], tree) }
    end
    local node = tree:add(item.field, tvb(at, octets))
    if item.is ~= "explicit" then
        local said = show_parts(tvb, at, item.parts, node)
        if octets > item.octets then
            node:add(item.undescribed, tvb(at + item.octets, octets - item.octets))
        end
        return said
    end
    local form = form_of(tvb, item, at, octets)
    if form then
        node:append_text(", " .. item.known_title)
        return show_parts(tvb, at + 1, form.parts, node)
    elseif octets > 1 then
        node:add(item.opaque, tvb(at + 1, octets - 1))
    end
    return {}
end

-- Records.

-- Octets of the FSPEC that begins at `at`; nil where it does not end before `stop`.
local function fspec_length(tvb, at, stop)
    for length = 1, stop - at do
        if tvb(at + length - 1, 1):uint() % 2 == 0 then
            return length
        end
    end
    return nil
end

-- The field reference numbers that an FSPEC announces, in their order.
local function announced(tvb, at, length)
    local frns = {}
    for index = 0, math.min(length, MOST_FSPEC) - 1 do
        for place = 0, 6 do
            if tvb(at + index, 1):bitfield(place, 1) == 1 then
                table.insert(frns, 7 * index + place + 1)
            end
        end
    end
    return frns
end

-- Where the record ends whose items begin at `at`; nil where it cannot be read. `long`: I129/120 has three octets.
local function end_of(tvb, frns, at, stop, long)
    for _, frn in ipairs(frns) do
        local octets = ITEMS[frn] and measure(tvb, ITEMS[frn], at, stop, long)
        if not octets then
            return nil
        end
        at = at + octets
    end
    return at
end

-- Shows the record that begins at `at`. Gives its end, or nil where the rest of the block cannot be read; and a line about it.
local function show_record(tvb, at, stop, tree)
    local record = tree:add(framing.record, tvb(at, stop - at))
    local length = fspec_length(tvb, at, stop)
    if not length then
        record:add(framing.fspec, tvb(at, stop - at)):add_proto_expert_info(faults.fspec_past_end)
        return nil, "cut off"
    end
    local fspec = record:add(framing.fspec, tvb(at, length))
    local frns = announced(tvb, at, length)
    -- The edition says 1 octet in one place and 3 in another. A block holds one record, so its end tells.
    local items = at + length
    local long = end_of(tvb, frns, items, stop, false) ~= stop and end_of(tvb, frns, items, stop, true) == stop

    local said, here = {}, items
    for _, frn in ipairs(frns) do
        local item = ITEMS[frn]
        if not item then
            local octet = at + math.floor((frn - 1) / 7)
            record:add(tvb(octet, 1), "FRN " .. frn .. " is reserved"):add_proto_expert_info(faults.reserved_frn)
            return nil, "cannot be read"
        end
        local octets, fault = measure(tvb, item, here, stop, long)
        if not octets then
            record:add(tvb(here, stop - here), item.name):add_proto_expert_info(faults[fault])
            return nil, "I129/" .. item.number .. " cut off"
        end
        said[item.number] = show_item(tvb, item, here, octets, record)
        here = here + octets
    end
    if length > MOST_FSPEC then
        fspec:add_proto_expert_info(faults.fspec_too_long)
        return nil, "cannot be read"
    end
    record:set_len(here - at)

    local line = {}
    local function say(number, key, before)
        local text = said[number] and said[number][key]
        if text then
            table.insert(line, (before or "") .. text)
        end
    end
    say("SP", "track_number", "track ")
    say("SP", "source")
    say("020", "")
    say("030", "")
    say("040", "", "serial ")
    say("080", "latitude_deg")
    say("080", "longitude_deg")
    local text = table.concat(line, " ")
    record:append_text(": " .. text)
    return here, text
end

-- Shows a block of this category; gives a line about it.
local function show_block(tvb, at, length, root)
    local stop = at + length
    local block = root:add(framing.block, tvb(at, length))
    block:add(framing.category, tvb(at, 1))
    local shown_length = block:add(framing.length, tvb(at + 1, 2))
    local count, lines, here = 0, {}, at + HEADER
    while here and here < stop do
        local line
        here, line = show_record(tvb, here, stop, block)
        count = count + 1
        table.insert(lines, line)
    end
    if count > 1 then
        shown_length:add_proto_expert_info(several)
    end
    return "CAT129 " .. table.concat(lines, " | ")
end

-- Datagrams.

-- The blocks of a datagram: { at, length, category }. Then where its rest begins that is none, and why; or nil.
local function blocks_of(tvb)
    local blocks, at = {}, 0
    local cut_off = tvb:reported_len() > tvb:len() and "not_captured" or "block_past_end"
    while at < tvb:len() do
        if tvb:len() - at < HEADER then
            return blocks, at, cut_off
        end
        local category, length = tvb(at, 1):uint(), tvb(at + 1, 2):uint()
        if length < HEADER then
            return blocks, at, "block_too_short"
        elseif at + length > tvb:len() then
            return blocks, at, cut_off
        end
        table.insert(blocks, { at = at, length = length, category = category })
        at = at + length
    end
    return blocks, nil
end

local function has_category(blocks)
    for _, block in ipairs(blocks) do
        if block.category == CATEGORY then
            return true
        end
    end
    return false
end

local found, asterix = pcall(Dissector.get, "asterix")
local others = found and asterix or Dissector.get("data")

function cat129.dissector(tvb, pinfo, root)
    local blocks, rest, fault = blocks_of(tvb)
    local is_ours = has_category(blocks) or (rest and tvb(rest, 1):uint() == CATEGORY)
    if not is_ours then
        return others:call(tvb, pinfo, root)
    end
    local tree = root:add(cat129, tvb())
    local lines = {}
    for _, block in ipairs(blocks) do
        if block.category == CATEGORY then
            table.insert(lines, show_block(tvb, block.at, block.length, tree))
        else
            others:call(tvb(block.at, block.length):tvb(), pinfo, root)
            table.insert(lines, string.format("CAT%03d", block.category))
        end
    end
    if rest then
        local range = tvb(rest, tvb:len() - rest)
        tree:add(range, "Not a block: " .. range:len() .. " octets"):add_proto_expert_info(faults[fault])
        table.insert(lines, "not a block")
    end
    pinfo.cols.protocol = "ASTERIX"
    pinfo.cols.info = table.concat(lines, ", ")
    return tvb:len()
end

-- A datagram that is nothing but blocks, one of them of this category, on any port.
cat129:register_heuristic("udp", function(tvb, pinfo, root)
    local blocks, rest = blocks_of(tvb)
    if rest or not has_category(blocks) then
        return false
    end
    cat129.dissector(tvb, pinfo, root)
    return true
end)

local udp_ports = DissectorTable.get("udp.port")
local registered
cat129.prefs.ports = Pref.range(
    "UDP ports", "8600", "Ports of ASTERIX; what has no CAT129 goes to Wireshark's own dissector, which has 8600 otherwise", 65535)

local function listen()
    local ports = cat129.prefs.ports
    if registered ~= ports then
        if registered and registered ~= "" then
            udp_ports:remove(registered, cat129)
        end
        if ports ~= "" then
            udp_ports:add(ports, cat129)
        end
        registered = ports
    end
end
cat129.prefs_changed = listen
listen()
