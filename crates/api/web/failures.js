// The banner: unavailable data, since when, and why.

import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

/** One line per cause, so that a failure of the whole service is one line. @param {Read[]} failures */
export function showFailures(failures) {
  const causes = Map.groupBy(failures, ({ why }) => why);
  const lines = [...causes].map(([why, reads]) => {
    const titles = reads.map(({ title }) => title).join(", ");
    const since = Math.min(...reads.map((read) => read.since));
    return `${titles}: not known since ${format.utc(since)} UTC (${why})`;
  });
  const list = byId("failures");
  list.hidden = lines.length === 0;
  // An unchanged line is not written again; otherwise screen readers would repeat it.
  while (list.children.length > lines.length) list.lastChild?.remove();
  while (list.children.length < lines.length) list.append(element("p"));
  lines.forEach((line, i) => setText(list.children[i], line));
}
