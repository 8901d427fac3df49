// The API page, generated from its documents: routes, events of the stream, and types of all answers.

const METHODS = ["get", "post"];

/** An element with attributes and content. Text is inserted as text, never as markup. */
function make(name, attributes = {}, ...content) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...content.filter((part) => part !== undefined && part !== ""));
  return element;
}

const code = (text) => make("code", {}, text);
const anchor = (...parts) => parts.join("-").replace(/[^A-Za-z0-9]+/g, "-").toLowerCase();

/** A table that scrolls by itself on narrow screens. */
function table(caption, heads, rows) {
  const head = make("tr", {}, ...heads.map((text) => make("th", { scope: "col" }, text)));
  const body = rows.map(([first, ...rest]) =>
    make("tr", {}, make("th", { scope: "row" }, first), ...rest.map((cell) => make("td", {}, cell))),
  );
  const all = make("table", {}, make("caption", {}, caption), make("thead", {}, head), make("tbody", {}, ...body));
  return make("div", { class: "scroll", role: "region", tabindex: "0", "aria-label": caption }, all);
}

function list(parts, between = ", ") {
  const fragment = document.createDocumentFragment();
  parts.forEach((part, index) => fragment.append(...(index > 0 ? [between] : []), part));
  return fragment;
}

/** A short description of a schema, with links to named types. */
function words(schema) {
  if (schema === undefined || schema === true) return "anything";
  if (schema.$ref) {
    const name = schema.$ref.split("/").pop();
    return make("a", { href: `#${anchor("type", name)}` }, name);
  }
  if ("const" in schema) return code(JSON.stringify(schema.const));
  if (schema.enum) return list(schema.enum.map((value) => code(JSON.stringify(value))), " or ");
  const several = schema.oneOf ?? schema.anyOf;
  if (several) return list(several.map(words), " or ");
  if (schema.type === "array") {
    const items = schema.prefixItems ? list(schema.prefixItems.map(words)) : words(schema.items);
    return list(["list of ", items], "");
  }
  const type = [schema.type ?? "anything"].flat().join(" or ");
  const bounds = [
    schema.format,
    "minimum" in schema ? `from ${schema.minimum}` : undefined,
    "maximum" in schema ? `to ${schema.maximum}` : undefined,
  ];
  const said = bounds.filter(Boolean).join(" ");
  return said ? `${type}, ${said}` : type;
}

/** The properties of an object as a table, or a description of another type. */
function shape(schema, name) {
  if (schema.properties) {
    const required = new Set(schema.required ?? []);
    const rows = Object.entries(schema.properties).map(([key, property]) => [
      code(key),
      words(property),
      required.has(key) ? "always" : "may be left out",
      property.description ?? "",
    ]);
    return [table(`Properties of ${name}`, ["Property", "Type", "There", "What"], rows)];
  }
  const several = schema.oneOf ?? schema.anyOf;
  if (several?.some((one) => one.properties)) {
    return several.flatMap((one, index) => shape(one, `${name}, ${one.description ?? `variant ${index + 1}`}`));
  }
  return [make("p", {}, "Is ", words(schema), ".")];
}

function route(path, method, operation) {
  const id = anchor(method, path);
  const label = make("span", { class: `method ${method}` }, method.toUpperCase());
  const section = make("section", { "aria-labelledby": id }, make("h3", { id }, label, " ", code(path)));
  section.append(make("p", {}, `${operation.summary}.`));
  if (operation.description) section.append(make("p", { class: "soft" }, operation.description));
  if (operation.parameters?.length) {
    const rows = operation.parameters.map((parameter) => [
      code(parameter.name),
      words(parameter.schema),
      parameter.required ? "always" : "may be left out",
      parameter.description ?? "a part of the path",
    ]);
    section.append(table(`Parameters of ${method.toUpperCase()} ${path}`, ["Parameter", "Type", "Given", "What"], rows));
  }
  const sent = operation.requestBody?.content;
  for (const [type, { schema }] of Object.entries(sent ?? {})) {
    section.append(make("p", {}, "Its body as ", code(type), ": ", words(schema), "."));
  }
  const rows = Object.entries(operation.responses).flatMap(([status, response]) => {
    const bodies = Object.entries(response.content ?? { "": undefined });
    return bodies.map(([type, content]) => [
      code(status),
      response.description,
      code(type),
      content ? words(content.schema) : "nothing",
    ]);
  });
  section.append(table(`Answers of ${method.toUpperCase()} ${path}`, ["Status", "When", "Media type", "Body"], rows));
  if (method === "get") section.append(make("pre", { tabindex: "0", "aria-label": "as a command" }, `curl '${location.origin}${path}'`));
  return { id, text: `${method.toUpperCase()} ${path}`, section };
}

function event(name, message) {
  const id = anchor("event", name);
  const section = make("section", { "aria-labelledby": id }, make("h3", { id }, code(name)));
  section.append(make("p", {}, `${message.summary}. Its data: `, words(message.payload), "."));
  return { id, text: name, section };
}

function type([name, schema]) {
  const id = anchor("type", name);
  const section = make("section", { "aria-labelledby": id }, make("h3", { id }, code(name)));
  if (schema.description) section.append(make("p", {}, schema.description));
  section.append(...shape(schema, name));
  return { id, text: name, section };
}

/** A chapter with its entries, and its links in the contents. */
function chapter(title, about, entries) {
  const id = anchor(title);
  const links = entries.map(({ id, text }) => make("li", {}, make("a", { href: `#${id}` }, text)));
  document.getElementById("contents").append(make("h2", {}, make("a", { href: `#${id}` }, title)), make("ul", {}, ...links));
  const heading = make("h2", { id }, title);
  document.getElementById("content").append(heading, make("p", {}, about), ...entries.map(({ section }) => section));
  return entries.map((entry, index) => ({ ...entry, item: links[index] }));
}

/** Shows the entries that contain all words of the search. */
function find(entries) {
  const wanted = document.getElementById("find").value.toLowerCase().split(/\s+/).filter(Boolean);
  let count = 0;
  for (const { section, item } of entries) {
    const text = section.textContent.toLowerCase();
    const is = wanted.every((word) => text.includes(word));
    section.hidden = item.hidden = !is;
    count += is ? 1 : 0;
  }
  document.getElementById("found").textContent = wanted.length ? `${count} of ${entries.length}` : "";
}

async function read(url) {
  const answer = await fetch(url, { credentials: "same-origin" });
  if (!answer.ok) throw new Error(`${url}: ${answer.status}`);
  return answer.json();
}

async function show() {
  const [api, stream] = await Promise.all([read("../openapi.json"), read("v1/asyncapi.json")]);
  document.getElementById("state").remove();
  document.getElementById("about").prepend(`Version ${api.info.version}. ${api.info.description} `);
  const routes = Object.entries(api.paths).flatMap(([path, operations]) =>
    METHODS.filter((method) => operations[method]).map((method) => route(path, method, operations[method])),
  );
  const { messages, schemas } = stream.components;
  const events = Object.keys(stream.channels.stream.messages).map((name) => event(name, messages[name]));
  const types = Object.entries({ ...schemas, ...api.components.schemas }).sort(([a], [b]) => (a < b ? -1 : 1)).map(type);
  const entries = [
    ...chapter("Routes", "What is asked for, with which parameters, and what is answered.", routes),
    ...chapter("Events", "What /api/v1/stream sends as Server-Sent Events, and /api/v1/stream/ws as messages.", events),
    ...chapter("Types", "Of answers and events.", types),
  ];
  document.getElementById("find").addEventListener("input", () => find(entries));
  // The browser looked for the fragment before its target existed.
  if (location.hash) document.getElementById(location.hash.slice(1))?.scrollIntoView();
}

show().catch((error) => {
  document.getElementById("state").textContent = `The documents could not be read: ${error.message}`;
});
