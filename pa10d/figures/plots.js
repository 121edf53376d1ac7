// Draws figures (Plotly JSON without colours for paper, text and grid) in the page's own colours.
const pa10dPlots = (() => {
  const NARROW = 480; // px
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  /** How much larger than usual the reader wants letters. */
  const larger = () => parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
  /** A figure's pixels for such letters. */
  const grown = (layout) => {
    const by = larger(), margin = Object.entries(layout.margin ?? {}).map(([side, size]) => [side, size * by]);
    return { ...layout, margin: Object.fromEntries(margin), ...(layout.height ? { height: layout.height * by } : {}) };
  };
  /** Words in lines of at most so many letters. */
  const lines = (text, most) => text.split(" ").reduce((done, word) => {
    const last = done.at(-1);
    return last && `${last} ${word}`.length <= most ? [...done.slice(0, -1), `${last} ${word}`] : [...done, word];
  }, []).join("<br>");
  /** What stands under a panel goes on in a second line where it would run into the next panel's. */
  const wrapped = (layout, width) => {
    const letter = 14.4 * larger() * 0.55, room = width - (layout.margin?.l ?? 0) - (layout.margin?.r ?? 0);
    const axes = Object.entries(layout).filter(([name, axis]) => /^xaxis\d*$/.test(name) && axis.title?.text).map(([name, axis]) => {
      const [begin, end] = axis.domain ?? [0, 1], most = Math.max(8, Math.floor((end - begin) * room / letter));
      return [name, { ...axis, title: { ...axis.title, text: lines(axis.title.text, most) } }];
    });
    return { ...layout, ...Object.fromEntries(axes) };
  };
  /** Panels that stand two by two stand one under the other where there is no room beside. */
  const stacked = (layout, width) => {
    const panels = Object.values(layout.meta?.panels ?? {}), n = panels.length, rows = Math.ceil(n / 2);
    if (n < 2 || width > NARROW * larger()) return layout;
    const [low, high] = layout.yaxis.domain, share = (high - low) * rows / n, out = { ...layout, height: layout.height * n / rows };
    panels.forEach((name, k) => {
      const y = name.replace("x", "y"), top = 1 - k / n;
      out[name] = { ...layout[name], domain: [0, 1] };
      out[y] = { ...layout[y], title: layout.yaxis.title, domain: [Math.max(0, top - share), top] };
    });
    return out;
  };
  /** So do two panels beside each other; the second one has the first one's axis title where it shared that axis. */
  const underEachOther = (layout, width) => {
    const left = layout.xaxis?.domain, right = layout.xaxis2?.domain, gap = 100 * larger();
    if (!(right?.[0] > 0) || width > NARROW * larger()) return layout;
    const inside = layout.height - (layout.margin?.t ?? 0) - (layout.margin?.b ?? 0), whole = 2 * inside + gap, share = inside / whole;
    const moved = (one) => one.xref !== "paper" || one.yref !== "paper" ? one
      : one.x < right[0] ? { ...one, x: one.x / left[1], y: 1 - share + share * one.y }
        : { ...one, x: (one.x - right[0]) / (right[1] - right[0]), y: share * one.y };
    const title = layout.yaxis2.title?.text ? layout.yaxis2.title : layout.yaxis.title;
    const legend = layout.legend && { ...layout.legend, y: 1 + ((layout.legend.y ?? 1) - 1) * share };
    return { ...layout, height: layout.height + inside + gap, legend, annotations: layout.annotations?.map(moved),
             xaxis: { ...layout.xaxis, domain: [0, 1] }, yaxis: { ...layout.yaxis, domain: [1 - share, 1] },
             xaxis2: { ...layout.xaxis2, domain: [0, 1] }, yaxis2: { ...layout.yaxis2, title, domain: [0, share] } };
  };
  const template = () => {
    const axis = { gridcolor: css("--grid"), linecolor: css("--line"), tickcolor: css("--line"),
                   zerolinecolor: css("--line"), spikecolor: css("--muted"), ticks: "outside",
                   ticklen: 4, showline: true };
    return { layout: {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: css("--text"), family: css("--font"), size: 12 * larger() },
      hoverlabel: { bgcolor: css("--card"), bordercolor: css("--line"),
                    font: { color: css("--text"), size: 13 * larger() } },
      modebar: { bgcolor: css("--card"), color: css("--line"), activecolor: css("--accent") },
      xaxis: axis, yaxis: axis } };
  };
  const config = { responsive: true, displaylogo: false, displayModeBar: "hover",
                   modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  const drawn = new Map(), widths = new WeakMap(), heights = new WeakMap(); // widths: drawn for; heights: before
  /** The buttons lie over the picture's upper right corner: where a legend reaches so far, they move up. */
  const clear = (box) => {
    const bar = box.querySelector(".modebar"), holder = box.querySelector(".modebar-container"), keys = [...box.querySelectorAll(".legend .legendtext")];
    if (!bar || !holder) return;
    const { left, height } = bar.getBoundingClientRect();
    const crowded = keys.some((key) => key.getBoundingClientRect().right > left);
    box.style.marginTop = crowded ? `${height}px` : "";
    holder.style.top = crowded ? `${-height}px` : "0px";
  };
  const draw = async (box, figure) => {
    const first = !drawn.has(box);
    drawn.set(box, figure);
    widths.set(box, box.clientWidth);
    if (first) heights.set(box, box.style.height);
    box.style.height = heights.get(box);
    const form = underEachOther(stacked(grown(figure.layout), box.clientWidth), box.clientWidth);
    if (form.height > box.clientHeight) box.style.height = `${form.height}px`;
    const layout = { ...wrapped(form, box.clientWidth), template: template(), autosize: true };
    const done = await Plotly.react(box, figure.data, layout, config);
    if (first) {
      box.on("plotly_afterplot", () => clear(box));
      resized.observe(box);
    }
    clear(box);
    return done;
  };
  /** The window, or a section that was not to be seen while the window or its colours changed. A zoom stays
      where the panels stay as they stand. */
  const resized = new ResizeObserver((entries) => {
    for (const { target: box } of entries) {
      const before = widths.get(box), width = box.clientWidth, narrow = NARROW * larger();
      if (!width || width === before) continue;
      if (!before || (width > narrow) !== (before > narrow)) draw(box, drawn.get(box));
      else {
        widths.set(box, width);
        Plotly.Plots.resize(box);
      }
    }
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const [box, figure] of drawn) {
      if (box.clientWidth) draw(box, figure);
      else widths.set(box, 0); // once it is seen again
    }
  });
  return { draw };
})();
