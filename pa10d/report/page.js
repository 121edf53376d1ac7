// Draws each plot when it comes near the window, fills the navigation, switches figures.
(() => {
  const figure = (id) => JSON.parse(document.getElementById(id).textContent);
  const show = (canvas) => pa10dPlots.draw(canvas, figure(canvas.dataset.figure));
  const watcher = new IntersectionObserver((entries) => {
    for (const entry of entries) {
      if (!entry.isIntersecting) continue;
      watcher.unobserve(entry.target);
      show(entry.target);
    }
  }, { rootMargin: "400px" });
  for (const canvas of document.querySelectorAll(".canvas")) watcher.observe(canvas);
  for (const choice of document.querySelectorAll(".plot select")) {
    const canvas = choice.closest(".plot").querySelector(".canvas");
    choice.addEventListener("change", () => { canvas.dataset.figure = choice.value; show(canvas); });
  }
  const bar = document.createElement("div");
  for (const section of document.querySelectorAll("section[data-title]")) {
    const link = document.createElement("a");
    link.href = "#" + section.id;
    link.textContent = section.dataset.title;
    link.addEventListener("click", () => {
      const folded = section.querySelector("details");
      if (folded) folded.open = true;
    });
    bar.append(link);
  }
  document.querySelector("nav").append(bar);
  addEventListener("beforeprint", () => document.querySelectorAll(".canvas").forEach(show));
})();
