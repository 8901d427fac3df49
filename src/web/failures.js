// The banner: what is not known, since when, and why.

import { byId, element, setText } from "./dom.js";
import * as format from "./format.js";

/** Of those with the same cause one line: when the whole service is gone, that is one thing to read. */
export function showFailures(failures) {
  const causes = Map.groupBy(failures, ({ why }) => why);
  const lines = [...causes].map(([why, reads]) => {
    const titles = reads.map(({ title }) => title).join(", ");
    const since = Math.min(...reads.map((read) => read.since));
    return `${titles}: not known since ${format.utc(since)} UTC (${why})`;
  });
  const list = byId("failures");
  list.hidden = lines.length === 0;
  // A line that stays is not written again, or it would be read out again.
  while (list.children.length > lines.length) list.lastChild.remove();
  while (list.children.length < lines.length) list.append(element("p"));
  lines.forEach((line, i) => setText(list.children[i], line));
}
