// Draws the figures of a page, whose data stand beside them; the library is unpacked once.
(async () => {
  const charts = [...document.querySelectorAll(".chart")];
  if (!("DecompressionStream" in window)) {
    for (const chart of charts) chart.textContent = "This figure needs a browser of 2023 or later.";
    return;
  }
  const packed = Uint8Array.from(atob(document.getElementById("plotly").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text();
  document.head.append(script);
  // A finger scrolls the page; only a mouse draws a rectangle to zoom in. Where nothing hovers, the bar of
  // tools would always lie over the legend.
  const touched = matchMedia("(pointer: coarse)").matches;
  const dragmode = touched ? false : "zoom";
  const displayModeBar = touched ? false : "hover";
  const config = { responsive: true, displaylogo: false, displayModeBar, modeBarButtonsToRemove: ["select2d", "lasso2d"] };
  // Where the words of a figure leave the bar no room, as a legend does in a narrow window, there is none.
  const meet = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
  const fit = (chart) => {
    chart.classList.remove("crowded");
    const bar = chart.querySelector(".modebar"), words = [...chart.querySelectorAll(".legend, .annotation")];
    if (!bar) return;
    const room = bar.getBoundingClientRect();
    chart.classList.toggle("crowded", words.some((word) => meet(word.getBoundingClientRect(), room)));
  };
  for (const chart of charts) {
    const { data, layout } = JSON.parse(chart.parentNode.querySelector(".figure").textContent);
    await Plotly.newPlot(chart, data, { ...layout, dragmode }, config);
    fit(chart);
    chart.on("plotly_afterplot", () => fit(chart));
  }
  // Paper is narrower than most screens, and does not tell that it is.
  const printed = 640;
  addEventListener("beforeprint", () => charts.forEach((chart) => Plotly.relayout(chart, { width: printed })));
  addEventListener("afterprint", () => charts.forEach((chart) => Plotly.relayout(chart, { width: null, autosize: true })));
  document.body.dataset.charts = "drawn";
})();
