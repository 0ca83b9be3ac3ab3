FROM python:3.12-slim AS build
RUN apt-get update && apt-get install -y --no-install-recommends g++
COPY . /source
RUN pip wheel --no-deps -w /wheel /source

FROM python:3.12-slim
COPY --from=build /wheel /wheel
RUN pip install --no-cache-dir "$(echo /wheel/mcpn-*.whl)[pictures,risk]"
WORKDIR /missions
ENTRYPOINT ["mcpn"]
