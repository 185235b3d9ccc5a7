(function () {
  // Without scripts the picture swings by itself. With them it moves into a shadow tree, where its ids and styles
  // meet those of no other picture, and gets a slider.
  const figure = document.currentScript && document.currentScript.parentElement;
  const image = figure && figure.querySelector("img");
  if (!image || !figure.attachShadow && !document.createElement("div").attachShadow) return;
  const host = document.createElement("div");
  const root = host.attachShadow({mode: "open"});
  const source = image.getAttribute("src");
  root.innerHTML = decodeURIComponent(source.slice(source.indexOf(",") + 1));
  const picture = root.querySelector("svg");
  if (!picture || !picture.setCurrentTime) return;
  const moving = document.createElement("style");
  moving.textContent = "svg{max-width:100%;height:auto}.r-move{display:inline!important}.r-still{display:none!important}";
  root.append(moving);
  image.replaceWith(host);

  const start = $start, end = $end, mirror = $mirror, duration = $duration;
  const bar = document.createElement("div");
  bar.style.cssText = "display:flex;gap:.5em;align-items:center";
  const button = document.createElement("button");
  button.type = "button";
  button.style.cssText = "font:inherit;color:inherit;background:none;border:0;padding:0 .3em;cursor:pointer;width:4em";
  const slider = document.createElement("input");
  slider.type = "range";
  slider.min = 0;
  slider.max = 1;
  slider.step = "any";
  slider.style.flex = "1";
  slider.setAttribute("aria-label", "time of the motion");
  bar.append(button, slider);
  host.after(bar);

  let plays = false;
  function play(wanted) {
    plays = wanted;
    button.textContent = plays ? "pause" : "play";
    if (plays) {
      picture.unpauseAnimations();
      window.requestAnimationFrame(follow);
    } else {
      picture.pauseAnimations();
    }
  }
  function follow() {
    if (!plays || !host.isConnected) return;
    const time = picture.getCurrentTime() % duration;
    slider.value = (Math.min(time, mirror - time) - start) / (end - start);
    window.requestAnimationFrame(follow);
  }
  slider.addEventListener("input", function () {
    play(false);
    picture.setCurrentTime(start + slider.valueAsNumber * (end - start));
  });
  button.addEventListener("click", function () { play(!plays); });
  const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  slider.value = still ? 0.35 : 0;
  if (still) picture.setCurrentTime(start + 0.35 * (end - start));
  play(!still);
})();
