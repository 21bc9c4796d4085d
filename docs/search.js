/* How the book's search orders what it finds, and what it quotes of it.

Sphinx takes it for its Scorer. Pages that teach a term come first: what docs/terms.csv names,
then headings, then lessons; names of the package only where they are asked for by name. */

var Scorer = {
  objNameMatch: 11,
  objPartialMatch: 0,
  objPrio: { 0: 0, 1: 0, 2: 0 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,

  score: ([page, title, , , score, , kind]) => {
    const query = new URLSearchParams(window.location.search).get("q").trim();
    if (kind === "index") return score + 100;
    if (kind === "object") {
      const named = [title, title.split(".").pop(), title.replace("freeseg", "fs")];
      return named.includes(query) ? 300 : score - 20;
    }
    const words = [...Search._parseQuery(query)[1]];
    const number = Search._index.docnames.indexOf(page);
    const inHeadings = words.every((word) =>
      [Search._index.titleterms[word] ?? []].flat().includes(number),
    );
    const inTitle = words.every((word) => title.toLowerCase().includes(word));
    return score + 20 * inTitle + 10 * inHeadings + Scorer.weight(page);
  },

  weight: (page) => {
    if (/^notebooks\/\d\d_/.test(page)) return 12;
    if (/^notebooks\/A\d_|^docs\/index$/.test(page)) return 8;
    if (/^notebooks\/(solutions|assignments)|CHANGELOG/.test(page)) return -16;
    return 0;
  },
};

// searchtools.js may come before this, or after it.
addEventListener("DOMContentLoaded", () => {
  /* The prose of a page or section: without code, what it prints, and equations on their own. */
  Search.htmlToText = (html, anchor) => {
    const page = new DOMParser().parseFromString(html, "text/html");
    const main = page.querySelector('[role="main"]');
    const part = (anchor && main?.querySelector(`[id="${anchor.slice(1)}"]`)) || main;
    if (!part) return "";
    const left = ".headerlink, script, style, .cell, div.math, .toctree-wrapper, div.highlight";
    part.querySelectorAll(left).forEach((one) => one.remove());
    part.querySelectorAll("span.math").forEach((one) => {
      one.textContent = one.textContent.replace(/\\(?:[()]|mathrm|[,;!])|[{}_^\\]/g, "");
    });
    return part.textContent.replace(/\s+/g, " ");
  };

  /* A quotation around the query, or else around the first of its words. */
  Search.makeSearchSummary = (html, words, anchor) => {
    const text = Search.htmlToText(html, anchor);
    if (!text) return null;
    const query = new URLSearchParams(window.location.search).get("q").trim().toLowerCase();
    const places = [query, ...words].map((one) => text.toLowerCase().indexOf(one));
    const place = places.find((one) => one >= 0) ?? 0;
    const begin = place > 120 ? text.indexOf(" ", place - 120) : 0;
    const end = Math.max(text.lastIndexOf(" ", begin + 260), begin + 200);
    const summary = document.createElement("p");
    summary.classList.add("context");
    summary.textContent =
      (begin ? "… " : "") + text.slice(begin, end).trim() + (end < text.length ? " …" : "");
    return summary;
  };
});
