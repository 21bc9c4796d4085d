/* A tap on a picture shows it as large as it is, on a ground of its own that scrolls. */
addEventListener("DOMContentLoaded", () => {
  const large = document.body.appendChild(document.createElement("dialog"));
  large.className = "large";
  large.addEventListener("click", () => large.close());
  for (const picture of document.querySelectorAll("article .cell_output img, article p > img")) {
    picture.tabIndex = 0;
    picture.setAttribute("role", "button");
    picture.title = "Show it larger";
    const show = () => {
      const copy = new Image();
      copy.src = picture.currentSrc || picture.src;
      copy.alt = picture.alt;
      large.replaceChildren(copy);
      large.showModal();
    };
    picture.addEventListener("click", show);
    picture.addEventListener("keydown", (key) => key.key === "Enter" && show());
  }
});
