// Draws figures (Plotly JSON without colours for paper, text and grid) in the page's own colours.
const pa10dPlots = (() => {
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  /** How much larger than usual the reader wants letters. */
  const larger = () => parseFloat(getComputedStyle(document.documentElement).fontSize) / 16;
  /** A figure's pixels for such letters. */
  const grown = (layout) => {
    const by = larger(), margin = Object.entries(layout.margin ?? {}).map(([side, size]) => [side, size * by]);
    return { ...layout, margin: Object.fromEntries(margin), ...(layout.height ? { height: layout.height * by } : {}) };
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
  const drawn = new Map();
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
    const layout = { ...grown(figure.layout), template: template(), autosize: true };
    const done = await Plotly.react(box, figure.data, layout, config);
    if (first) box.on("plotly_afterplot", () => clear(box));
    clear(box);
    return done;
  };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    for (const [box, figure] of drawn) draw(box, figure);
  });
  return { draw };
})();
